"""Analyses, jobs, results and tables of properties on the command line: on a store, and through a server."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import mcml_service.cli
from mcml_service.actions.importing.load_demo import REACHES, add_clips
from mcml_service.app import create_app
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.test_authentication import listening

Run = Callable[..., tuple[int, str, str]]
WISH = ("attributes.age=40", "attributes.height=172", "attributes.hbp=320")


@pytest.fixture(scope="module")
def library(sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with twelve reaches and two dances."""
    path = tmp_path_factory.mktemp("library") / "store.db"
    shutil.copy(sqlite_template, path)
    database = Database(f"sqlite:///{path}")
    reaches = [item.clip for item in reach_clips(3, young=(2, 2, 2), old=(2, 2, 2))]
    add_clips(database, Settings(), REACHES, reaches, (), "")
    dances = [dance_clip("groove", tempo=tempo, bars=8, name=f"dance_{tempo}").clip for tempo in (110, 120)]
    add_clips(database, Settings(), "dances", dances, (), "")
    database.close()
    return path


@pytest.fixture
def mcml(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs `mcml` in this process on a copy of the library; answers (exit code, output, errors)."""
    shutil.copy(library, tmp_path / "store.db")
    monkeypatch.setenv("MCML_DATABASE", f"sqlite:///{tmp_path / 'store.db'}")
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["mcml", *words])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            mcml_service.cli.main()
        said = capsys.readouterr()
        code = ended.value.code
        return (code if isinstance(code, int) else 0), said.out, said.err

    return run


@pytest.fixture
def server(mcml: Run, lent_workers: None, tmp_path: Path) -> Iterator[str]:
    database = Database(f"sqlite:///{tmp_path / 'store.db'}")
    with listening(create_app(Settings(host="127.0.0.1"), database)) as port:
        yield f"http://127.0.0.1:{port}"
    database.close()


def fitted(mcml: Run, *where: str) -> str:
    code, output, errors = mcml("analyse", "reach", "fit", "--project", REACHES, "components=4", "--json", *where)
    assert code == 0, errors
    job = json.loads(output)
    assert (job["state"], len(job["inputs"]), job["parameters"]["components"]) == ("done", 12, 4)
    return str(job["result"])


@pytest.mark.slow
@pytest.mark.parametrize("place", ["here", "server"])
def test_reach_from_fit_to_file(mcml: Run, tmp_path: Path, place: str, request: pytest.FixtureRequest) -> None:
    where = ("--server", request.getfixturevalue("server")) if place == "server" else ()
    result = fitted(mcml, *where)
    assert result in mcml("analyse", "results", *where)[1]
    code, output, errors = mcml("analyse", "reach", "picture", result, "-o", "fit.png", "--dpi", "40", *where)
    assert (code, Path("fit.png").read_bytes()[:4]) == (0, b"\x89PNG"), errors
    assert mcml("analyse", "reach", "picture", result, "-o", "fit.jpg", *where)[0] == 2
    code, _, errors = mcml("analyse", "reach", "picture", result, "--name", "none", *where)
    assert (code, "variance" in errors) == (1, True), "what there is to draw is named"
    shown = mcml("analyse", "reach", "info", result, *where)[1]
    assert "synthesize" in shown
    assert "name age, unit year" in shown, "what the model can be asked for"
    code, output, _ = mcml("analyse", "reach", "synthesize", result, *WISH, *where)
    assert code == 0
    assert json.loads(output)["value"]["support"] in ("inside", "gap", "outside")
    code, output, errors = mcml("analyse", "reach", "synthesize", result, *WISH, "-o", "made.bvh", "--save", *where)
    assert (code, output.split()[0]) == (0, "wrote"), errors
    assert (tmp_path / "made.bvh").read_text().startswith("HIERARCHY")
    assert mcml("validate", "made.bvh")[0] == 0
    listed = json.loads(mcml("ls", "--project", REACHES, "--json", *where)[1])
    assert listed["total"] == 13
    code, _, errors = mcml("analyse", "reach", "synthesize", result, "attributes.age=40", *where)
    assert code == 1
    assert "height" in errors
    jobs = json.loads(mcml("jobs", "list", "--json", *where)[1])["items"]
    assert [(job["state"], job["result"]) for job in jobs] == [("done", result)]
    assert mcml("jobs", "show", jobs[0]["id"], *where)[0] == 0
    assert mcml("jobs", "watch", jobs[0]["id"], *where)[0] == 0
    assert mcml("analyse", "delete", result, *where)[0] == 0
    assert mcml("analyse", "reach", "info", result, *where)[0] == 1


def test_a_failed_analysis_says_why(mcml: Run) -> None:
    code, _, errors = mcml("analyse", "reach", "fit", "--project", REACHES, 'attributes=["shoe"]')
    assert code == 1
    assert "shoe" in errors
    code, _, errors = mcml("analyse", "reach", "fit", "--project", "nothing")
    assert code == 1
    assert "no project" in errors
    code, _, errors = mcml("analyse", "reach", "fit", "--project", REACHES, "components=many")
    assert code == 2
    assert "components" in errors
    assert mcml("analyse", "reach", "fit", "--project", REACHES, "nonsense")[0] == 2


@pytest.mark.slow
def test_a_queued_job_waits_for_a_server(mcml: Run, request: pytest.FixtureRequest) -> None:
    code, output, _ = mcml("analyse", "dance", "beats", "--project", "dances", "--queue", "--json")
    assert code == 0
    job = json.loads(output)
    assert job["state"] == "waiting"
    request.getfixturevalue("server")
    code, output, _ = mcml("jobs", "watch", job["id"], "--json")
    assert code == 0
    assert json.loads(output)["state"] == "done"


def test_a_waiting_job_is_cancelled(mcml: Run) -> None:
    job = json.loads(mcml("analyse", "dance", "beats", "--project", "dances", "--queue", "--json")[1])
    assert mcml("jobs", "cancel", job["id"])[1].startswith("cancelled")
    assert mcml("jobs", "show", job["id"])[0] == 1


def test_bars_become_motion_names_and_dances_documents(mcml: Run) -> None:
    code, _, errors = mcml("analyse", "dance", "beats", "--project", "dances", 'labels=["bars"]')
    assert code == 0, errors
    assert int(mcml("xpath", "//frame[motion_name='bar-2']", "--project", "dances", "--as", "count")[1]) > 50
    code, output, errors = mcml(
        "analyse", "dance", "make", "--project", "dances", "bpm=116", "bars=4", "--into", "made", "--json"
    )
    assert code == 0, errors
    result = json.loads(mcml("analyse", "dance", "info", json.loads(output)["result"], "--json")[1])
    document = result["parts"]["clip"]["document"]
    shown = json.loads(mcml("show", document, "--json")[1])
    assert shown["project"] == "made"
    assert shown["duration"] == pytest.approx(16 * 60 / 116, abs=2 * shown["seconds_per_frame"])
    code, _, errors = mcml(
        "analyse",
        "dance",
        "make",
        "--project",
        "dances",
        "bpm=116",
        "bars=4",
        'dancers={"count": 2}',
        "--into",
        "pairs",
    )
    assert code == 0, errors
    roots = "//bone[name='dancer1:Root' or name='dancer2:Root']"
    assert mcml("xpath", roots, "--project", "pairs", "--as", "count")[1].strip() == "2"


def test_properties_from_a_table(mcml: Run, tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("name,shoe (EU)\nreach_01_001,42\nreach_01_002,42\n")
    code, output, _ = mcml("properties", "table.csv")
    assert (code, output.splitlines()[-1]) == (0, "2 changed")
    assert mcml("xpath", "//property[@name='shoe'][@unit='EU']", "--as", "count")[1].strip() == "2"
    (tmp_path / "table.csv").write_text("name,shoe\nreach_01_001,43\nnobody,42\n")
    code, _, errors = mcml("properties", "table.csv")
    assert code == 1
    assert "table.csv:3" in errors
    assert mcml("xpath", "//property[@name='shoe'][@value='43']", "--as", "count")[1].strip() == "0"


def test_labels_and_frames_of_many(mcml: Run, tmp_path: Path) -> None:
    code, _, errors = mcml(
        "labels", "query", "bent", "//frame[frame_bone[@name='spine']/@Rx > 5]", "--project", "dances"
    )
    assert code == 0, errors
    assert mcml("labels", "export", "labels.csv", "--project", "dances")[0] == 0
    text = (tmp_path / "labels.csv").read_text()
    assert text.startswith("document,label,first,last")
    assert mcml("labels", "import", "labels.csv", "--replace")[0] == 0
    assert mcml("labels", "export", "again.csv", "--project", "dances")[0] == 0
    assert (tmp_path / "again.csv").read_text() == text
    uuid = json.loads(mcml("ls", "--project", "dances", "--json")[1])["items"][0]["id"]
    frames = json.loads(mcml("show", uuid, "--json")[1])["frames"]
    assert f"{frames - 10:,} frames" in mcml("frames", uuid, "delete", "1-10")[1]
    assert f"{frames - 5:,} frames" in mcml("frames", uuid, "insert", "1-5", "--to", "1")[1]
    assert mcml("frames", uuid, "move", "1-5")[0] == 2
    assert mcml("frames", uuid, "keep", "1-99999")[0] == 1


def test_compose(mcml: Run) -> None:
    items = json.loads(mcml("ls", "--project", "dances", "--json")[1])["items"]
    one, two = (item["id"] for item in items)
    code, output, errors = mcml("compose", f"{one}:1-60", f"{two}:30-90", "--preview")
    assert code == 0, errors
    assert "transition" in output
    code, output, errors = mcml("compose", f"{one}:1-60", f"{one}:61-90", "--name", "piece", "--json")
    assert code == 0, errors
    made = json.loads(output)
    assert made["frames"] == 90
    assert json.loads(mcml("show", made["document"], "--json")[1])["name"] == "piece"
    assert mcml("compose", "//frame[motion_name='nothing']")[0] == 1


def test_retarget(mcml: Run) -> None:
    one, two = (item["id"] for item in json.loads(mcml("ls", "--project", "dances", "--json")[1])["items"])
    code, output, errors = mcml("retarget", one, two, "--preview")
    assert (code, errors) == (0, "")
    assert "would make" in output
    assert "->" in output
    code, output, errors = mcml("retarget", one, two, "--clean-feet", "--name", "brought", "--json")
    assert (code, errors) == (0, "")
    assert json.loads(output)["document"] in mcml("ls", "--json")[1]
    assert mcml("retarget", one, two, "--joint", "left_hand")[0] == 2
    code, output, errors = mcml("retarget", one, two, "--joint", "no_such=root")
    assert code == 1
    assert "no_such" in errors
