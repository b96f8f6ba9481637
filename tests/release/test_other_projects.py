"""The wheel beside other people's code: packages of the same names as our folders, type checkers, and no server.

No network: all other packages are those of this environment.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from service.web.build import WEB, install
from tests.builders import bvh

TAKEN = ("service", "schemas", "tests", "migrations", "web", "api", "storage")
"""Packages of the other project, each of which may not be imported by us."""

SCRIPT = """
import mcml
from mcml.frames import Frames

walk = mcml.read("walk.bvh")
frames: Frames = walk.frames("Root", space="positions")
highest: float = float(walk.height("Head").max())

with mcml.open("store.db") as repo:
    stored = repo.import_("walk.bvh", label=["walk:1-2"]).documents[0]
    named: str = stored.name
    seconds: float | None = stored.frame_time
    page = repo.operations.list_documents(q="walk", limit=5)
    first: str = page.items[0].name
    detail = repo.operations.get_document(id=stored.id)
    count: int = detail.frames
    for run in repo.xpath("//frame[motion_name='walk']").runs():
        print(named, run.first, run.last, count, len(frames))
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with packages of its own that end whoever imports them."""
    for name in TAKEN:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f'raise SystemExit("the other {name} was imported")\n')
    (tmp_path / "walk.bvh").write_bytes(bvh())
    (tmp_path / "script.py").write_text(SCRIPT.replace("unit = walk.calibration.unit if False else None\n", ""))
    return tmp_path


@pytest.fixture
def run(installed: Path, project: Path) -> Callable[..., str]:
    """Run a program of the environment in the project, which is on the path of Python too."""

    def run(*command: str | Path) -> str:
        name, *others = command
        done = subprocess.run(
            [installed / name, *others], cwd=project, env=environment_of(project), capture_output=True, text=True
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


def environment_of(project: Path) -> dict[str, str]:
    named = {"PYTHONPATH": str(project), "MCML_DATABASE": f"sqlite:///{project / 'store.db'}"}
    return os.environ | named | {"XDG_DATA_HOME": str(project / "data"), "XDG_CACHE_HOME": str(project / "cache")}


@pytest.mark.slow
def test_a_script_reads_files_and_opens_a_store(run: Callable[..., str]) -> None:
    assert run("python", "script.py") == "walk 1 2 3 3\n"


@pytest.mark.slow
def test_commands_and_jobs_in_processes_run(run: Callable[..., str]) -> None:
    run("mcml", "demo")
    run("mcml", "analyse", "dance", "beats", "--project", "demo-dance")
    assert json.loads(run("mcml", "analyse", "results", "--json"))["items"]


@pytest.mark.fuzz  # Long: in `make test` a script asks (above).
def test_a_file_is_imported_and_asked_by_commands(run: Callable[..., str]) -> None:
    run("mcml", "import", "walk.bvh")
    assert run("mcml", "xpath", "count(//frame)").strip() == "3"


@pytest.mark.slow
def test_a_server_is_asked(run: Callable[..., str], installed: Path, project: Path) -> None:
    run("mcml", "import", "walk.bvh")
    with served(installed, project) as address:
        asked = f"import mcml; repo = mcml.open({address!r}); print(repo.xpath('count(//frame)').value())"
        assert float(run("python", "-c", asked)) == 3
        assert run("mcml", "ls", "--server", address).count("walk") >= 1
        page = httpx.get(address, headers={"accept": "text/html"})
        assert page.status_code == 200
        assert "is not built here" not in page.text, "the wheel carries the studio"


@contextmanager
def served(installed: Path, project: Path) -> Iterator[str]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [installed / "mcml", "serve", "--port", str(port)]
    said = (project / "said.txt").open("wb")
    with subprocess.Popen(command, cwd=project, env=environment_of(project), stdout=said, stderr=said) as server:
        try:
            address = f"http://127.0.0.1:{port}"
            end = time.monotonic() + 60
            while not _answers(address):
                assert server.poll() is None, (project / "said.txt").read_text()
                assert time.monotonic() < end, "the server does not answer"
                time.sleep(0.1)
            yield address
        finally:
            server.terminate()


def _answers(address: str) -> bool:
    try:
        return httpx.get(f"{address}/healthz", verify=False).is_success
    except httpx.HTTPError:
        return False


@pytest.mark.slow
def test_mypy_sees_types_of_every_call(installed: Path, project: Path) -> None:
    for name in TAKEN:
        (project / name / "__init__.py").write_text("")
    wrong = project / "wrong.py"
    wrong.write_text("import mcml\nmcml.open('x.db').operations.list_documents(limit='five')\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--python-executable"]
    files = [str(installed / "python"), "script.py", "wrong.py"]
    done = subprocess.run([*command, *files], cwd=project, capture_output=True, text=True)
    (error,) = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert error.startswith("wrong.py:2:")
    assert 'incompatible type "str"' in error


@pytest.mark.fuzz  # Long: in `make test` mypy goes over the same script.
def test_pyright_sees_types_of_every_call(installed: Path, project: Path) -> None:
    for name in TAKEN:
        (project / name / "__init__.py").write_text("")
    (project / "pyrightconfig.json").write_text('{"strict": ["script.py"], "include": ["script.py"]}')
    node, environment = install()
    command = [*node, str(WEB / "node_modules/pyright/index.js"), "--pythonpath", str(installed / "python")]
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_without_the_server_files_are_read_and_the_command_says_what_it_needs(installed: Path, project: Path) -> None:
    """As a base installation is: a finder hides the packages of the extra `server`."""
    hidden = ("fastapi", "starlette", "sqlalchemy", "alembic", "dask", "distributed", "typer", "pydantic_settings")
    (project / "hide.py").write_text(
        "import sys\n"
        "class Hidden:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name.partition('.')[0] in {hidden!r}:\n"
        "            raise ModuleNotFoundError(f'No module named {name!r}', name=name)\n"
        "sys.meta_path.insert(0, Hidden())\n"
    )

    def run(text: str) -> subprocess.CompletedProcess[str]:
        command = [str(installed / "python"), "-c", f"import hide\n{text}"]
        return subprocess.run(command, cwd=project, env=environment_of(project), capture_output=True, text=True)

    read = "import mcml\nprint(len(mcml.read('walk.bvh').height('Head')))\nmcml.convert('walk.bvh', 'walk.mcml')"
    assert run(read).stdout == "3\n"
    asked = run("from mcml_service.command import main\nmain()")
    assert asked.returncode == 1
    assert "pip install 'mcml-repository[server]'" in asked.stderr
