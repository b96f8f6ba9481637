"""Edits, undo, restored revisions, deletion and purges of others in any order: what each revision left stays readable.

A model keeps the MCML that every revision left; the store is compared with it after each step, on both databases.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from mcml_schemas.documents import DocumentChange, LabelRequest
from mcml_schemas.elements import ElementChange
from mcml_schemas.frames import FrameEdits
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.local_store import Local
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import bvh, store

FRAMES = st.integers(1, 40)


class Story(RuleBasedStateMachine):
    """One document and what its revisions left, by their numbers."""

    new_store: Callable[[ExitStack], str]

    def __init__(self) -> None:
        super().__init__()
        self.stack = ExitStack()
        self.database = Database(type(self).new_store(self.stack))
        self.stack.callback(self.database.close)
        self.client = Local(self.database, Settings())
        self.left: dict[int, bytes] = {}
        self.gone = False

    @initialize(frames=st.integers(2, 30), seed=st.integers(0, 3))
    def begin(self, frames: int, seed: int) -> None:
        self.uuid = store(self.database, {"walk.bvh": bvh(frames, seed=seed)}, project="gait")[0]
        self._note()

    def _mcml(self, revision: int | None = None) -> bytes:
        content = self.client.call("get_mcml", id=self.uuid, revision=revision)
        return b"".join(map(bytes, content.blocks))

    def _note(self) -> None:
        """Keep what is there now as what its revision left."""
        found = self.client.call("get_document", id=self.uuid)
        self.frames = found.frames
        self.revision = found.revision
        self.left[found.revision] = self._mcml()

    def _edit(self, name: str, **given: Any) -> None:
        self.client.call(name, id=self.uuid, if_match="*", **given)
        self._note()

    @precondition(lambda self: not self.gone)
    @rule(frame=FRAMES, bone=st.integers(1, 3), value=st.sampled_from(["0", "-12.5", "1e3", "90.0001"]))
    def set_a_value(self, frame: int, bone: int, value: str) -> None:
        xpath = f"/mcml/motion/frame[{min(frame, self.frames)}]/frame_bone[{bone}]"
        self._edit("change_element", xpath=xpath, change=ElementChange(attributes={"Rx": value}))

    @precondition(lambda self: not self.gone)
    @rule(first=FRAMES, length=st.integers(0, 9), name=st.sampled_from(["walk", "jump", "걷기"]))
    def name_frames(self, first: int, length: int, name: str) -> None:
        first = min(first, self.frames)
        label = LabelRequest(name=name, first=first, last=min(first + length, self.frames))
        self._edit("add_labels", labels=[label])

    @precondition(lambda self: not self.gone and self.frames > 3)
    @rule(first=FRAMES, do=st.sampled_from(["delete", "reverse"]))
    def change_frames(self, first: int, do: str) -> None:
        first = min(first, self.frames - 1)
        edit = {"do": do, "first": first, "last": first + 1}
        self._edit("edit_frames", edits=FrameEdits.model_validate({"edits": [edit]}))

    @precondition(lambda self: not self.gone)
    @rule(name=st.sampled_from(["one", "two"]))
    def rename(self, name: str) -> None:
        self._edit("change_document", change=DocumentChange(name=name, description=name))

    @precondition(lambda self: not self.gone and self.revision > 1)
    @rule()
    def undo(self) -> None:
        before = self.left[self.revision - 1]
        self._edit("undo_revision")
        assert self.left[self.revision] == before

    @precondition(lambda self: not self.gone and self.revision > 1)
    @rule(data=st.data())
    def restore_a_revision(self, data: st.DataObject) -> None:
        number = data.draw(st.integers(1, self.revision - 1))
        self._edit("restore_document", revision=number)
        assert self.left[self.revision] == self.left[number]

    @rule()
    def delete_or_bring_back(self) -> None:
        if self.gone:
            self.client.call("restore_document", id=self.uuid, if_match="*")
            self.gone = False
            self._note()
        else:
            self.client.call("delete_document", id=self.uuid, if_match="*")
            self.gone = True

    @rule(seed=st.integers(0, 3))
    def purge_another(self, seed: int) -> None:
        """A document with the same skeleton, and perhaps the same file, goes for good."""
        other = store(self.database, {"other.bvh": bvh(5, seed=seed)}, project="gait")[0]
        self.client.call("delete_document", id=other, if_match="*")
        purge_documents(self.database, [other])

    @precondition(lambda self: not self.gone and bool(self.left))
    @invariant()
    def the_past_is_as_it_was(self) -> None:
        assert self._mcml() == self.left[self.revision]
        for number in {1, self.revision - 1} & set(self.left):
            assert self._mcml(number) == self.left[number]

    def teardown(self) -> None:
        try:
            assert self.database.check(past=True) == []
        finally:
            self.client.close()
            self.stack.close()


def _run(kind: str, request: pytest.FixtureRequest, examples: int, steps: int, number: int | None = None) -> None:
    def new_store(stack: ExitStack) -> str:
        if kind == "sqlite":
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            shutil.copy(request.getfixturevalue("sqlite_template"), folder / "store.db")
            return f"sqlite:///{folder / 'store.db'}"
        server = request.getfixturevalue("postgres_template")
        return str(stack.enter_context(postgres.new_database(server, "template_store")))

    class Told(Story):
        pass

    Told.new_store = staticmethod(new_store)
    if number is not None:
        hypothesis.seed(number)(Told)
    run_state_machine_as_test(Told, settings=settings(max_examples=examples, stateful_step_count=steps))


@pytest.mark.slow
def test_stories_of_edits(kind: str, request: pytest.FixtureRequest) -> None:
    _run(kind, request, 8 if kind == "sqlite" else 4, 12)


@pytest.mark.fuzz(seeds=1)
def test_many_stories_of_edits(kind: str, request: pytest.FixtureRequest, seed: int) -> None:
    _run(kind, request, 150, 40, seed)
