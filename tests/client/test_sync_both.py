"""New and changed documents go into a folder; a sync that is stopped anywhere continues."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mcml.client.client import Client
from mcml.client.sync.bindings import Bindings
from mcml.errors import NotFoundError
from tests import fuzz
from tests.builders import ASF, amc, bvh, one_kind
from tests.client.synced_folder import Synced

pytestmark = one_kind


def test_new_and_changed_documents_are_written_into_the_folder(synced: Synced, library: Client) -> None:
    other = Synced(library, synced.folder.with_name("other"))
    other.put("walk.bvh", bvh(3))
    other.put("leg.asf", ASF)
    other.put("leg.amc", amc(3))
    other.put("sub/walk.bvh", bvh(5))
    other.run()
    assert {action for action, _ in synced.actions(both=True)} == {"fetched"}
    files = synced.files()
    assert [path for path in files if "/" not in path] == ["leg.amc", "leg.asf", "walk.bvh"]
    assert {(synced.folder / path).read_bytes() for path in files} == {bvh(3), bvh(5), ASF, amc(3)}
    assert synced.actions(both=True) == []
    library.call("add_labels", id=synced.uuid("leg"), labels=[{"name": "hop", "first": 1, "last": 2}], if_match="*")
    assert synced.actions(both=True) == [("fetched", "leg.mcml")]
    first = (synced.folder / "leg.mcml").read_bytes()
    assert b"hop" in first
    assert synced.actions(both=True) == []
    library.call("add_labels", id=synced.uuid("leg"), labels=[{"name": "skip", "first": 3, "last": 3}], if_match="*")
    assert synced.actions(both=True) == [("fetched", "leg.mcml")]
    assert b"skip" in (synced.folder / "leg.mcml").read_bytes()
    assert (synced.folder / "leg.amc").read_bytes() == amc(3)
    synced.put("leg.amc", amc(4))
    assert synced.actions(both=True) == [("conflict", "leg.amc")]


def test_a_changed_download_is_sent_back_and_never_overwritten(synced: Synced, library: Client) -> None:
    synced.put("walk.bvh", bvh(30))
    synced.run()
    uuid = synced.uuid("walk")
    library.call("add_labels", id=uuid, labels=[{"name": "hop", "first": 1, "last": 2}], if_match="*")
    synced.run(both=True)
    edited = synced.folder / "walk.mcml"
    content = edited.read_text()
    assert 'Tx="' in content
    start = content.index('Tx="') + 4
    changed = content[:start] + "7.5" + content[content.index('"', start) :]
    edited.write_text(changed)
    assert synced.actions(both=True) == [("replaced", "walk.mcml")]
    assert synced.actions(both=True) == []
    library.call("add_labels", id=uuid, labels=[{"name": "skip", "first": 3, "last": 3}], if_match="*")
    edited.write_text(changed.replace("7.5", "8.5"))
    assert synced.actions(both=True) == [("conflict", "walk.mcml")]
    assert "8.5" in edited.read_text()
    assert synced.client.call("get_document", id=uuid).revision == 4


def test_names_in_the_folder_are_never_overwritten(synced: Synced, library: Client) -> None:
    other = Synced(library, synced.folder.with_name("other"))
    other.put("walk.bvh", bvh(3))
    other.run()
    synced.put("walk.bvh", bvh(3)[:-40])
    actions = synced.actions(both=True)
    uuid = synced.uuid("walk")
    assert actions == [("failed", "walk.bvh"), ("fetched", f"walk-{uuid[-6:]}/walk.bvh")]
    assert (synced.folder / "walk.bvh").read_bytes() == bvh(3)[:-40]
    library.call("delete_document", id=uuid, if_match="*")
    assert ("left", f"walk-{uuid[-6:]}/walk.bvh") in synced.actions(both=True)


def test_a_file_that_changes_during_a_download_stays(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    synced.put("walk.bvh", bvh(5))
    synced.run()
    for number in (1, 2):
        label = {"name": f"hop {number}", "first": 1, "last": 2}
        synced.client.call("add_labels", id=synced.uuid("walk"), labels=[label], if_match="*")
        call = synced.client.call

        def editing(name: str, **given: Any) -> Any:
            answer = call(name, **given)  # noqa: B023
            if name == "export_document":
                synced.put("walk.mcml", b"mine")
            return answer

        with monkeypatch.context() as patch:
            patch.setattr(synced.client, "call", editing)
            assert ("fetched", "walk.mcml") not in synced.actions(both=True)
        assert (synced.folder / "walk.mcml").read_bytes() == b"mine"
        (synced.folder / "walk.mcml").unlink()
        assert ("fetched", "walk.mcml") in synced.actions(both=True) or number == 2


def test_a_document_that_cannot_be_written_stops_no_other(synced: Synced, monkeypatch: pytest.MonkeyPatch) -> None:
    other = Synced(synced.client, synced.folder.with_name("other"))
    for name in "abc":
        other.put(f"{name}.bvh", bvh(3, seed=ord(name)))
    other.run()
    uuid, call = synced.uuid("b"), synced.client.call

    def failing(name: str, **given: Any) -> Any:
        if name == "get_document" and given["id"] == uuid:
            raise NotFoundError("There is no document.")
        return call(name, **given)

    with monkeypatch.context() as patch:
        patch.setattr(synced.client, "call", failing)
        assert synced.actions(both=True) == [("failed", "b"), ("fetched", "a.bvh"), ("fetched", "c.bvh")]
    assert synced.actions(both=True) == [("fetched", "b.bvh")]


class _Stop(BaseException):
    """An interruption."""


@pytest.mark.slow
@pytest.mark.parametrize("both", fuzz.share([True, False], 2))
def test_a_sync_that_is_stopped_anywhere_continues(synced: Synced, monkeypatch: pytest.MonkeyPatch, both: bool) -> None:
    """Before and after each request and each write of the record."""
    step = 0
    fatal = 0

    def stopping(act: Callable[..., Any]) -> Callable[..., Any]:
        def run(*given: Any, **more: Any) -> Any:
            nonlocal step
            step += 1
            if step == fatal:
                raise _Stop
            answer = act(*given, **more)
            step += 1
            if step == fatal:
                raise _Stop
            return answer

        return run

    synced.put("leg.asf", ASF)
    synced.put("leg.amc", amc(2))
    synced.put("walk.bvh", bvh(3))
    synced.run()
    leg, call = synced.uuid("leg"), synced.client.call
    other = Synced(synced.client, synced.folder.with_name("other"))
    monkeypatch.setattr(synced.client, "call", stopping(synced.client.call))
    monkeypatch.setattr(Bindings, "save", stopping(Bindings.save))
    monkeypatch.setattr(Path, "replace", stopping(Path.replace))
    last = 0
    while True:
        last += 1
        step = -1000
        other.put(f"made {last}.bvh", bvh(3, seed=100 + last))
        other.run()
        call("add_labels", id=leg, labels=[{"name": f"hop {last}", "first": 1, "last": 2}], if_match="*")
        synced.put("walk.bvh", bvh(10 + last))
        synced.put(f"new {last}.bvh", bvh(3, seed=200 + last))
        step, fatal = 0, last
        try:
            synced.run(both=both)
            break
        except _Stop:
            step = -1000
            synced.run(both=both)
            assert synced.actions(both=both) == [], last
    assert last > (25 if both else 12)
    step = -1000
    assert synced.actions(both=both) == []
    numbers = range(1, last + 1)
    names = ["leg", "walk", *(f"{word} {number}" for word in ("made", "new") for number in numbers)]
    assert synced.names() == sorted(names)
    assert synced.client.call("get_document", id=synced.uuid("walk")).revision == last + 1
    files = {"leg.amc", "leg.asf", "walk.bvh", *(f"new {number}.bvh" for number in numbers)}
    fetched = {"leg.mcml", *(f"made {number}.bvh" for number in numbers)} if both else set()
    assert set(synced.files()) == files | fetched
    assert not both or f"hop {last}".encode() in (synced.folder / "leg.mcml").read_bytes()


@pytest.mark.parametrize("seed", range(2))
def test_random_changes_on_both_sides_lose_nothing(synced: Synced, seed: int) -> None:
    _change_at_random(synced, seed)


@pytest.mark.fuzz(seeds=40)
def test_many_random_changes_on_both_sides_lose_nothing(synced: Synced, seed: int) -> None:
    _change_at_random(synced, seed)


def _change_at_random(synced: Synced, seed: int) -> None:
    """After each sync: files are as people left them, documents have the frames of their files, and a second sync does
    nothing.
    """
    chance = random.Random(seed)
    for number in range(30):
        path = chance.choice(["a.bvh", "b.bvh", "sub/a.bvh"])
        deed = chance.choice(["write", "write", "write", "remove", "move", "edit", "edit", "delete"])
        items = synced.client.every("list_documents", project="film").items
        if deed == "write":
            # Some contents come again.
            synced.put(path, bvh(chance.choice([number + 3, 40, 41])))
        elif deed == "remove":
            (synced.folder / path).unlink(missing_ok=True)
        elif deed == "move" and (synced.folder / path).exists():
            (synced.folder / path).rename(synced.folder / "moved.bvh")
        elif items and deed == "edit":
            label = {"name": f"hop {number}", "first": 1, "last": 2}
            synced.client.call("add_labels", id=chance.choice(items).id, labels=[label], if_match="*")
        elif items and deed == "delete" and chance.random() < 0.3:
            synced.client.call("delete_document", id=chance.choice(items).id, if_match="*")
        if chance.random() < 0.4:
            continue
        content = {path: (synced.folder / path).read_bytes() for path in synced.files()}
        both = chance.random() < 0.5
        events = synced.run(both=both)
        after = {path: (synced.folder / path).read_bytes() for path in synced.files()}
        assert after.keys() >= content.keys()
        assert all(after[path] == text for path, text in content.items() if path.endswith(".bvh")), number
        refused = {event.path for event in events if event.action in ("failed", "conflict")}
        _check_bindings(synced, after, refused)
        assert not {event.action for event in synced.run(both=both)} & {"stored", "skipped", "replaced", "fetched"}


def _check_bindings(synced: Synced, files: dict[str, bytes], refused: set[str]) -> None:
    bindings = Bindings.read(synced.folder, "here", "film").all()
    bound = {path for binding in bindings for path in binding.files}
    assert set(files) - refused <= bound
    stored = {item.id: item for item in synced.client.every("list_documents", project="film").items}
    for binding in bindings:
        item = stored.get(binding.document)
        [path] = binding.files
        if item is not None and item.revision == binding.revision and path in files and path not in refused:
            assert path.endswith(".mcml") or b"Frames: %d\n" % item.frames in files[path], path
