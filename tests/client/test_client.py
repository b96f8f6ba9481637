"""The Python package: the same answers from a store of this machine and from a server, and files without either."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest

import mcml
from mcml.client.client import Client
from mcml.client.remote import Remote
from mcml.errors import ConflictError, McmlError, NotFoundError, RequestError
from mcml_schemas.frames import FrameEdits
from mcml_service.actions.importing.load_demo import demo_files
from mcml_service.local_store import Local
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF, amc, bvh, one_kind, served, source

pytestmark = pytest.mark.above_store

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(params=["local", "remote"])
def client(request: pytest.FixtureRequest, database: Database) -> Iterator[Client]:
    """Operations here, and through a server on the same store."""
    settings = Settings(page_limit=3)
    if request.param == "local":
        with Local(database, settings) as local:
            yield local
    else:
        with served(database, settings, base_url="http://127.0.0.1:8000/api/v1/") as http:
            yield Remote("http://127.0.0.1:8000", http=http)  # type: ignore[arg-type]


@pytest.fixture
def repo(client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> mcml.Repository:
    """Five clips of 4 to 8 frames, with motion names, in two projects."""
    monkeypatch.chdir(tmp_path)
    made = mcml.Repository(client)
    for number in range(5):
        path = Path(f"clip{number}.bvh")
        path.write_bytes(bvh(4 + number, seed=number))
        project = "even" if number % 2 == 0 else "odd"
        made.import_(path, project=project, label=[f"walk:{1 + number % 2}-3"], property=[f"age={20 + number}"])
    return made


def test_documents_are_found(repo: mcml.Repository) -> None:
    assert [item.name for item in repo.documents()] == [f"clip{number}" for number in range(5)]
    assert [item.name for item in repo.documents(project="odd")] == ["clip1", "clip3"]
    assert [item.name for item in repo.documents(property=["age:22..23"])] == ["clip2", "clip3"]
    assert [item.name for item in repo.documents(xpath="//frame[7]")] == ["clip3", "clip4"]
    assert [item.name for item in repo.documents(xpath="//frame[1]", project="odd")] == ["clip1", "clip3"]
    clip = repo.document("clip3")
    assert repo.document(clip.id).name == "clip3"
    # All ids of one test begin alike, so a beginning that is too short means several.
    with pytest.raises(ConflictError, match="more than one"):
        repo.document(clip.id[:2])
    with pytest.raises(NotFoundError, match="no document nobody"):
        repo.document("nobody")
    assert repo.projects() == ["even", "odd"]


@one_kind
def test_questions(repo: mcml.Repository) -> None:
    asked = repo.xpath("//frame[motion_name=$name]", name="walk")
    assert [(run.first, run.last, run.frames) for run in asked.runs()] == [(1, 3, 3), (2, 3, 2)] * 2 + [(1, 3, 3)]
    assert asked.count() == 13
    assert len(list(asked.nodes())) == 13
    assert repo.xpath("count(//frame)").value() == 30
    frames = repo.xpath("count(//frame)", per="document").value()
    assert frames == {item.id: len(item) for item in repo.documents()}
    assert repo.xpath("//frame", per="document").count() == 30
    assert repo.xpath("1 to 5").value() == [1, 2, 3, 4, 5]
    assert repo.xpath("distinct-values(//motion_name)").value() == ["walk"]
    table = repo.xpath("//bone/name").to_pandas()
    assert set(table["value"]) == {"<name>Spine</name>", "<name>Head</name>"}
    with pytest.raises(mcml.Error) as refused:
        repo.xpath("//frame[").runs()
    assert refused.value.remedy


@one_kind
def test_frames_are_those_of_the_file(repo: mcml.Repository) -> None:
    clip = repo.document("clip2")
    read = mcml.read("clip2.bvh")
    for space in ("channels", "positions", "rotations"):
        stored, alone = clip.frames(space=space), read.frames(space=space)
        np.testing.assert_array_equal(np.asarray(stored), np.asarray(alone))
        assert stored.columns == alone.columns
        np.testing.assert_array_equal(stored.times, alone.times)
        assert stored.ids == alone.ids == [str(number + 1) for number in range(6)]
    some = clip.frames("Spine", "Root", first=2, last=6, step=2, space="positions")
    assert (some.shape, some.columns) == ((3, 2, 3), ["Spine", "Root"])
    np.testing.assert_array_equal(some[:, 1], np.asarray(read.frames("Root", space="positions"))[1::2, 0])
    frame = some.to_pandas()
    assert list(frame.columns)[:3] == ["Spine.x", "Spine.y", "Spine.z"]
    np.testing.assert_array_equal(frame.to_numpy(), np.asarray(some).reshape(3, -1))


@one_kind
def test_what_numpy_makes_of_frames_is_plain(repo: mcml.Repository) -> None:
    frames = repo.document("clip0").frames("Root")
    assert type(frames[1:]) is type(frames + 1) is np.ndarray
    assert float(frames.mean()) == float(np.asarray(frames).mean())


def test_changes_are_revisions(repo: mcml.Repository) -> None:
    clip = repo.document("clip0")
    clip.rename("other").move("third", "because").set(unit="cm").label("jump", 2, 3)
    assert (clip.name, clip.project, clip.revision) == ("other", "third", 5)
    assert [(label.name, label.first, label.last) for label in clip.labels()] == [("walk", 1, 3), ("jump", 2, 3)]
    clip.undo()
    assert [label.name for label in clip.labels()] == ["walk"]
    assert clip.detail().unit == "cm"
    clip.delete()
    assert "other" not in [item.name for item in repo.documents()]
    repo.operations.restore_document(id=clip.id, if_match="*")
    assert clip.refresh().project == "third"


@one_kind
def test_files_are_not_replaced(repo: mcml.Repository) -> None:
    clip = repo.document("clip1")
    with pytest.raises(mcml.Error, match="exists"):
        clip.export("clip1.bvh")
    assert clip.export("clip1.bvh", force=True).read_bytes() == bvh(5, seed=1)
    assert clip.export("clip1.htr").stat().st_size > 100
    with pytest.raises(mcml.Error, match="is read"):
        mcml.convert("clip1.bvh", "clip1.bvh", force=True)
    with pytest.raises(mcml.Error, match="does not say"):
        clip.export("clip1.unknown")
    assert not list(Path(".").glob("*.part"))


@one_kind
def test_a_folder_is_stored_and_what_is_wrong_is_told(client: Client, tmp_path: Path) -> None:
    (tmp_path / "leg.asf").write_bytes(ASF)
    (tmp_path / "leg.amc").write_bytes(amc(4))
    (tmp_path / "walk.bvh").write_bytes(bvh(3))
    (tmp_path / "bad.bvh").write_bytes(bvh(3)[:-40])
    told: list[tuple[int, int]] = []
    repo = mcml.Repository(client)
    done = repo.import_(tmp_path, project="all", progress=lambda count, of, name: told.append((count, of)))
    assert sorted(item.name for item in done.documents) == ["leg", "walk"]
    assert [item.file for item in done.problems] == ["bad.bvh"]
    assert told[0] == (0, 4)
    assert told[-1] == (4, 4)
    with pytest.raises(mcml.Error, match="nothing here that can be read"):
        repo.import_(Path(__file__).parent)


@one_kind
def test_arguments_are_checked_before_anything_is_asked(client: Client) -> None:
    with pytest.raises(RequestError, match="no argument 'projectt'"):
        client.call("list_documents", projectt="x")
    with pytest.raises(RequestError, match="limit"):
        client.call("list_documents", limit=0)
    with pytest.raises(RequestError, match="id is missing"):
        client.call("get_document")
    with pytest.raises(NotFoundError, match="no operation"):
        client.call("list_document")


@one_kind
def test_errors_say_the_same_here_and_from_a_server(client: Client) -> None:
    with pytest.raises(mcml.Error) as refused:
        client.call("get_document", id="01a1fd5b-63fa-7af5-9027-3f8ccdfe4736")
    assert refused.value.what.startswith("There is no document 01a1fd5b")
    assert refused.value.remedy is not None


def _examples() -> list[str]:
    return [f"mcml.{module.name}" for module in pkgutil.iter_modules(mcml.__path__)]


@pytest.fixture
def demo_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "walk.bvh").write_bytes(demo_files()["walk.bvh"])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_examples_of_the_page_run(demo_folder: Path) -> None:
    failed, tried = doctest.testfile(str(DOCS / "python.md"), module_relative=False)
    assert (failed, tried > 25) == (0, True)


@pytest.mark.parametrize("name", ["mcml", *_examples()])
def test_examples_of_docstrings_run(demo_folder: Path, name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_a_server_that_is_too_busy_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the whole of the file each time; other refusals are told at once."""
    waited: list[float] = []
    monkeypatch.setattr("mcml.client.remote.time.sleep", waited.append)
    busy = {"type": "/docs/problems#busy-error", "title": "Busy error", "status": 503, "detail": "100 wait already."}
    share = busy | {"type": "/docs/problems#share-error", "status": 429}
    away = busy | {"type": "/docs/problems#unavailable-error"}
    bodies: list[bytes] = []
    left = [busy, share]

    def answer(request: httpx.Request) -> httpx.Response:
        bodies.append(request.read())
        if left:
            return httpx.Response(left[0]["status"], json=left.pop(0), headers={"retry-after": "5"})  # type: ignore[arg-type]
        return httpx.Response(201, json={"documents": [], "problems": []})

    client = Remote("", http=httpx.Client(base_url="http://server/api/v1", transport=httpx.MockTransport(answer)))
    assert client.call("upload_documents", file=[source("a.bvh", bvh(3))]).documents == []
    assert (waited, len(bodies)) == ([5, 5], 3)
    assert all(bvh(3) in body for body in bodies)
    left.append(away)
    with pytest.raises(McmlError, match="100 wait"):
        client.call("list_documents")
    left += [busy] * 1000
    monkeypatch.setattr("mcml.client.remote.BUSY", 1.0)
    with pytest.raises(McmlError, match="100 wait"):
        client.call("list_documents")
    assert waited == [5, 5]


def test_curves_of_a_dry_run(repo: mcml.Repository) -> None:
    """The answer has the samples of the same edit, here and from a server, and nothing is changed."""
    clip = repo.operations.get_document(id=repo.document("clip3").id)
    column = f"{clip.bones[0].name}.{clip.bones[0].channels[0]}"
    edits = FrameEdits.model_validate({"edits": [{"do": "reverse", "first": 2, "last": 6}]})
    done = repo.operations.edit_frames(id=clip.id, edits=edits, dry_run=True, column=[column], if_match="*")
    (curve,) = done.curves
    assert (curve.name, curve.before.first, curve.before.step) == (column, 2, 1)
    assert len(set(curve.before.minimum)) > 1
    assert curve.after.minimum == curve.before.minimum[::-1]
    assert repo.operations.get_document(id=clip.id) == clip


@pytest.mark.slow
def test_a_job_is_finished(repo: mcml.Repository) -> None:
    """Here it is run by the caller, on a server by the server."""
    stages: list[str] = []
    job = repo.operations.start_gait(request={"inputs": {"documents": [repo.document("clip3").id]}, "parameters": {}})
    done = repo.finish(job, lambda stage, share: stages.append(stage))
    assert done.state in ("done", "failed")
    assert (done.result is None) == (done.problem is not None)
    assert repo.operations.get_job(id=job.id).state == done.state
