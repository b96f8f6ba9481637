"""Every shell example of README and docs runs, in the order of its page, on a store and a server that serves it."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mcml.files.import_options import Label
from mcml_service.actions.importing.load_demo import demo_files
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.api.test_authentication import listening
from tests.builders import SECRET, store
from tests.docs.generate import DOCS
from tests.docs.starter import CLIENT

ROOT = DOCS.parent
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^(mcml|curl) ", re.MULTILINE)
NOT_RUN = {"run-a-server.md": "a server of PostgreSQL for others, which a test has not"}
"""Pages with blocks that are no shell examples to be run, and why."""


LONG = ("analyses.md", "stories.md")
"""Pages whose examples run analyses, 20 to 55 s each: they run in `make fuzz`."""


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of each block of a page."""
    return BLOCK.findall(page.read_text())


PAGES = [page for page in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))] if "sh" in dict(blocks(page))]


@pytest.fixture
def served_library(page: Path, request: pytest.FixtureRequest, sqlite_template: Path, tmp_path: Path) -> Database:
    """What a page is about: the demo library for those with analyses, else a walk and a reach in the project gait."""
    path = tmp_path / "store.db"
    demo = page.name == "analyses.md"
    alone = demo or page.name in ("README.md", "getting-started.md", "stories.md") or "tasks" in page.parts
    shutil.copy(request.getfixturevalue("demo_library") if demo else sqlite_template, path)
    database = Database(f"sqlite:///{path}")
    files = demo_files()
    walk, reach = {"walk.bvh": files.pop("walk.bvh")}, files
    if not alone:
        labels = (Label("walk"), Label("left-leg-flexion", 20, 60))
        store(database, walk, project="gait", name="walk", labels=labels, unit="cm")
        store(database, reach, project="gait", name="reach", frame_time="0.0166667", unit="cm")
        for name, content in (walk | reach).items():
            (tmp_path / name).write_bytes(content)
    return database


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with an `mcml` that starts at once, and what else the program's own folder has."""
    folder = tmp_path_factory.mktemp("bin")
    path = folder / "starter"
    with subprocess.Popen([sys.executable, "-m", "tests.docs.starter", path], stdout=subprocess.PIPE) as starter:
        assert starter.stdout is not None
        assert starter.stdout.readline() == b"ready\n"
        client = folder / "mcml"
        client.write_text(CLIENT.format(python=sys.executable, path=str(path)))
        client.chmod(0o755)
        yield folder
        starter.terminate()


def test_every_example_is_one_that_runs() -> None:
    for page in [ROOT / "README.md", *DOCS.rglob("*.md")]:
        for language, text in blocks(page):
            if COMMAND.search(text) and page.name not in NOT_RUN:
                assert language == "sh", (page.name, text)


@pytest.mark.slow
@pytest.mark.skipif(not (shutil.which("curl") and shutil.which("jq")), reason="curl or jq is not installed")
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.fuzz] * (page.name in LONG), id=page.stem) for page in PAGES],
)
def test_examples_run(page: Path, served_library: Database, tmp_path: Path, programs: Path) -> None:
    (tmp_path / ".curlrc").write_text("fail\nsilent\nshow-error\n")
    with served_library.read() as tx:
        names = {item.name: item.uuid for item in tx.documents.page(DocumentFilter(), after=None, limit=1000)}
    app = create_app(Settings(host="127.0.0.1"), served_library, lambda: SECRET)
    with listening(app) as port:
        text = "\n".join(text for language, text in blocks(page) if language == "sh")
        text = text.replace("127.0.0.1:8000", f"127.0.0.1:{port}").replace("localhost:8000", f"127.0.0.1:{port}")
        environment = {
            "PATH": f"{programs}:{Path(sys.executable).parent}:/usr/bin:/bin",
            "HOME": str(tmp_path),
            "CURL_HOME": str(tmp_path),
            "XDG_DATA_HOME": str(tmp_path / "home"),
            "MCML_DATABASE": f"sqlite:///{tmp_path / 'store.db'}",
            "LANG": "C.UTF-8",
            **dict.fromkeys(("ID", "WALK"), names.get("walk", "")),
            "ROBOT": names.get("reach", ""),
        }
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-x", "-c", text],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            timeout=240,
        )
    served_library.close()
    assert done.returncode == 0, done.stderr.decode()[-3000:] + done.stdout.decode()[-500:]
