"""New and changed files of a folder go to a project, on a server, through its REST API."""

from __future__ import annotations

import io
import json
import os
import shutil
import zipfile
from collections import Counter
from typing import Any

import pytest
from scipy.spatial.transform import Rotation

from mcml.client.client import Client
from mcml.client.sync import looks
from mcml.client.sync.bindings import STATE, Bindings
from mcml.errors import ConflictError, DocumentError, UnavailableError
from mcml.formats.format import SourceFile
from tests.builders import ASF, amc, bvh, one_kind
from tests.client.synced_folder import Synced
from tests.force_trials import make_trial
from tests.formats.readers.test_gltf import TIMES, TURNS, gltf, model_of

pytestmark = one_kind


def test_new_files_are_imported_once(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.put("day 1/걷기.bvh", bvh(4))
    synced.put("day 2/walk.bvh", bvh(5))
    synced.put("notes.txt", b"no motion")
    synced.put(".hidden/walk.bvh", bvh(6))
    assert synced.actions() == [("stored", "day 1/걷기.bvh"), ("stored", "day 2/walk.bvh"), ("stored", "walk.bvh")]
    assert synced.actions() == []
    assert synced.names() == ["walk", "walk", "걷기"]


def test_names_in_other_encodings(synced: Synced) -> None:
    """Of older systems, as bytes that are not UTF-8."""
    name = os.fsdecode("걷기.bvh".encode("cp949"))
    synced.put(name, bvh(3))
    assert synced.actions() == [("stored", name)]
    assert synced.names() == ["걷기"]
    synced.put(name, bvh(4))
    assert synced.actions() == [("replaced", name)]
    synced.put(name, bvh(4)[:-40])
    assert synced.actions() == [("failed", name)]
    assert synced.actions() == [("failed", name)]


def test_a_changed_file_replaces_the_frames_of_its_document(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(30))
    synced.run()
    uuid = synced.uuid("walk")
    synced.client.call("get_document", id=uuid)
    synced.put("walk.bvh", bvh(35))
    assert [(event.action, event.document, event.revision) for event in synced.run()] == [("replaced", uuid, 2)]
    assert synced.client.call("get_document", id=uuid).frames == 35
    assert synced.actions() == []
    synced.put("walk.bvh", bvh(35).replace(b"\n", b"\r\n"))
    assert synced.actions() == [], "the frames are the same"
    assert synced.client.call("get_document", id=uuid).revision == 2


def test_unchanged_files_are_not_sent(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.run()
    (synced.folder / "walk.bvh").touch()
    calls = _watch_calls(synced.client, monkeypatch)
    assert synced.actions() == []
    assert calls == Counter()


def _watch_calls(client: Client, monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    calls: Counter[str] = Counter()
    call = client.call

    def counted(name: str, **given: Any) -> Any:
        calls[name] += 1
        return call(name, **given)

    monkeypatch.setattr(client, "call", counted)
    return calls


def test_many_files_are_few_calls(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(10):
        synced.put(f"{number}.bvh", bvh(2, seed=number))
    synced.put("4.bvh", bvh(3)[:-40])
    calls = _watch_calls(synced.client, monkeypatch)
    counts = Counter(action for action, _ in synced.actions())
    assert (counts, calls["upload_documents"]) == ({"stored": 9, "failed": 1}, 1)
    synced.put("4.bvh", bvh(2, seed=4))
    assert synced.actions() == [("stored", "4.bvh")]


def test_a_document_that_changed_is_not_overwritten(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(30))
    synced.run()
    uuid = synced.uuid("walk")
    synced.client.call("add_labels", id=uuid, labels=[{"name": "hop", "first": 1, "last": 2}], if_match="*")
    synced.put("walk.bvh", bvh(35))
    rounds = synced.start()
    [event] = rounds.run()
    assert (event.action, event.path, event.document) == ("conflict", "walk.bvh", uuid)
    assert f"mcml import FILE --as {uuid}" in event.remedy
    assert list(rounds.run()) == [], "told once"
    assert synced.client.call("get_document", id=uuid).frames == 30
    with io.BytesIO(bvh(35)) as stream:
        synced.client.call("replace_file", id=uuid, file=[SourceFile("walk.bvh", stream)], if_match="*")
    assert list(rounds.run()) == []
    assert synced.actions() == [], "the remedy settles it"
    synced.put("walk.bvh", bvh(36))
    assert synced.actions() == [("replaced", "walk.bvh")]


def test_a_deleted_document_is_a_conflict(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.run()
    synced.client.call("delete_document", id=synced.uuid("walk"), if_match="*")
    assert synced.actions() == []
    synced.put("walk.bvh", bvh(4))
    [event] = synced.run()
    assert (event.action, "deleted" in event.detail) == ("conflict", True)


def test_another_skeleton_is_refused_with_a_remedy(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.run()
    synced.put("walk.bvh", bvh(3, names=("Root", "Spine")))
    [event] = synced.run()
    assert (event.action, "Rename the file" in event.remedy) == ("failed", True)
    (synced.folder / "walk.bvh").rename(synced.folder / "other.bvh")
    assert synced.actions() == [("gone", "walk.bvh"), ("stored", "other.bvh")]


def test_files_that_go_and_move(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.run()
    uuid = synced.uuid("walk")
    (synced.folder / "walk.bvh").unlink()
    assert synced.actions() == [("gone", "walk.bvh")]
    synced.put("moved/stride.bvh", bvh(3))
    assert synced.actions() == [("skipped", "moved/stride.bvh")]
    synced.put("moved/stride.bvh", bvh(5))
    assert [(event.action, event.document) for event in synced.run()] == [("replaced", uuid)]
    assert synced.names() == ["walk"]


def test_a_changed_copy_is_a_document_of_its_own(synced: Synced) -> None:
    synced.put("a.bvh", bvh(3))
    synced.put("b.bvh", bvh(3))
    assert synced.actions() == [("skipped", "b.bvh"), ("stored", "a.bvh")]
    synced.put("b.bvh", bvh(4))
    assert synced.actions() == [("stored", "b.bvh")]
    assert synced.names() == ["a", "b"]
    assert synced.original("a") == bvh(3)


def test_motions_are_sent_with_their_skeletons(synced: Synced) -> None:
    for place in ("one", "two"):
        synced.put(f"{place}/leg.asf", ASF)
        synced.put(f"{place}/leg.amc", amc(3 if place == "one" else 4))
    assert synced.actions() == [("stored", "one/leg.amc"), ("stored", "two/leg.amc")]
    synced.put("one/leg.amc", amc(5))
    synced.put("one/leg_02.amc", amc(6))
    assert synced.actions() == [("replaced", "one/leg.amc"), ("stored", "one/leg_02.amc")]
    assert synced.actions() == []
    assert synced.names() == ["leg", "leg", "leg_02"]
    synced.put("alone.amc", amc(2))
    [event] = synced.run()
    assert (event.action, event.path) == ("failed", "alone.amc")


def test_a_gltf_is_sent_with_its_buffer(synced: Synced) -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    synced.put("scene/walk.gltf", gltf(model, binary, form="text"))
    synced.put("scene/folder/numbers one.bin", binary)
    synced.put("other.bin", b"of another program")
    assert synced.actions() == [("stored", "scene/walk.gltf")]
    assert synced.actions() == []


def test_a_trc_is_sent_with_its_forces(synced: Synced) -> None:
    make_trial(1).write(synced.folder)
    (synced.folder / "walk.loads.xml").write_bytes(b"<OpenSimDocument><ExternalLoads/></OpenSimDocument>")
    assert synced.actions() == [("stored", "walk.trc")]
    items = synced.client.call("list_measurements", id=synced.uuid("walk")).items
    assert {item.name for item in items if item.function == "force"} >= {"1", "2"}
    assert synced.actions() == []


def test_takes_of_a_file_are_documents(synced: Synced) -> None:
    synced.put("scene.glb", _takes(Walk=1.0, Run=2.0))
    assert synced.actions() == [("stored", "scene.glb"), ("stored", "scene.glb")]
    assert synced.actions() == []
    synced.put("scene.glb", _takes(Walk=1.0, Run=3.0, Hop=4.0))
    assert synced.actions() == [("replaced", "scene.glb"), ("stored", "scene.glb")]
    assert synced.names() == ["scene#Hop", "scene#Run", "scene#Walk"]
    assert synced.actions() == []
    synced.put("scene.glb", _takes(Walk=1.0, Hop=4.0))
    [event] = synced.run()
    assert (event.action, "no take" in event.detail) == ("failed", True)


def _takes(**turns: float) -> bytes:
    rotations = [TURNS * Rotation.from_rotvec([0, turn, 0]) for turn in turns.values()]
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, rotation.as_quat()) for rotation in rotations])
    [all_in_one] = model["animations"]  # type: ignore[misc]
    model["animations"] = [
        {"name": name, "samplers": all_in_one["samplers"], "channels": [channel]}
        for name, channel in zip(turns, all_in_one["channels"], strict=True)
    ]
    return gltf(model, binary)


def test_a_changed_gltf_may_name_another_buffer(synced: Synced) -> None:
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())])
    synced.put("walk.gltf", gltf(model, binary, form="text"))
    synced.put("folder/numbers one.bin", binary)
    synced.run()
    model, binary = model_of([(1, "rotation", "LINEAR", TIMES, TURNS.inv().as_quat())])
    synced.put("walk.gltf", gltf(model, binary, form="text").replace(b"one.bin", b"two.bin"))
    synced.put("folder/numbers two.bin", binary)
    (synced.folder / "folder/numbers one.bin").unlink()
    assert synced.actions() == [("replaced", "walk.gltf")]
    assert synced.actions() == []


def test_archives(synced: Synced) -> None:
    synced.put("many.zip", _zipped({"a.bvh": bvh(2), "b.bvh": bvh(3)}))
    synced.put("one.zip", _zipped({"c.bvh": bvh(4)}))
    assert synced.actions() == [("stored", "many.zip"), ("stored", "many.zip"), ("stored", "one.zip")]
    assert synced.actions() == []
    synced.put("one.zip", _zipped({"c.bvh": bvh(5)}))
    assert synced.actions() == [("replaced", "one.zip")]
    synced.put("many.zip", _zipped({"a.bvh": bvh(6), "b.bvh": bvh(3)}))
    actions = synced.run()
    assert {event.action for event in actions} == {"failed"}
    assert "Put its files into the folder" in actions[0].remedy


def _zipped(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def test_a_file_that_is_being_written_waits(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    synced.put("done.bvh", bvh(3))
    synced.put("walk.bvh", bvh(30)[:-200])
    monkeypatch.setattr(looks, "SETTLE_SECONDS", 1e6)

    def write_more(_seconds: float) -> None:
        synced.put("walk.bvh", bvh(30))
        monkeypatch.setattr(looks, "SETTLE_SECONDS", 0)

    monkeypatch.setattr(looks.time, "sleep", write_more)
    assert synced.actions() == [("stored", "done.bvh"), ("waiting", "walk.bvh")]
    assert synced.actions() == [("stored", "walk.bvh")]


def test_a_file_that_changes_while_it_is_sent_is_sent_again(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    synced.put("walk.bvh", bvh(30))
    call = synced.client.call

    def changing(name: str, **given: Any) -> Any:
        answer = call(name, **given)
        if name in ("upload_documents", "replace_file"):
            synced.put("walk.bvh", bvh(40 if name == "upload_documents" else 50))
        return answer

    with monkeypatch.context() as patch:
        patch.setattr(synced.client, "call", changing)
        assert synced.actions() == [("stored", "walk.bvh")]
        assert synced.actions() == [("replaced", "walk.bvh")]
    assert synced.actions() == [("replaced", "walk.bvh")]
    assert synced.client.call("get_document", id=synced.uuid("walk")).frames == 50


def test_an_unreachable_repository_ends_the_round(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    synced.put("walk.bvh", bvh(3))

    def gone(*_: object, **__: object) -> None:
        raise UnavailableError("The server is unreachable.")

    with monkeypatch.context() as patch:
        patch.setattr(synced.client, "call", gone)
        with pytest.raises(UnavailableError):
            synced.run()
    assert synced.actions() == [("stored", "walk.bvh")]


def test_the_record_is_of_one_repository_and_project(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(3))
    synced.run()
    with pytest.raises(ConflictError, match="synced with the repository here"):
        Bindings.read(synced.folder, "there", "film")
    with pytest.raises(ConflictError, match="project film"):
        Bindings.read(synced.folder, "here", "gait")
    path = synced.folder / STATE
    for content in (b"", b"[]", b'{"version": 9}', b"\xff", json.dumps({"version": 1}).encode()):
        path.write_bytes(content)
        with pytest.raises(DocumentError, match="damaged"):
            synced.run()
    path.unlink()
    assert synced.actions() == [("skipped", "walk.bvh")]


def test_without_the_record_edited_documents_are_kept(synced: Synced) -> None:
    synced.put("walk.bvh", bvh(30))
    synced.run()
    with io.BytesIO(bvh(20)) as stream:
        shorter = [SourceFile("walk.bvh", stream)]
        synced.client.call("replace_file", id=synced.uuid("walk"), file=shorter, if_match="*")
    (synced.folder / STATE).unlink()
    assert synced.actions() == [("skipped", "walk.bvh")]
    synced.put("walk.bvh", bvh(31))
    assert synced.actions() == [("conflict", "walk.bvh")]


def test_a_folder_of_another_machine(synced: Synced) -> None:
    """Paths are relative: the folder may be moved."""
    synced.put("sub/walk.bvh", bvh(3))
    synced.run()
    moved = synced.folder.with_name("moved")
    shutil.move(synced.folder, moved)
    assert Synced(synced.client, moved).actions() == []
