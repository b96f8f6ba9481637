"""Stored clips of which an analysis measures the gait, one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, cast

from mcml.laboratory.gait_trials import Trial
from mcml.laboratory.measure_gait import EventSource
from mcml.language.elements import to_head
from mcml_service.actions.composing.load_motions import Input, find_document
from mcml_service.actions.reading.compare_gait import measure_trial
from mcml_service.clips.bodies import read_bodies
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

if TYPE_CHECKING:
    from mcml_service.storage.documents.columns import Listed


class StoredTrial:
    """See `TrialSource`. Each trial is read in a transaction of its own, so that a long job holds none open."""

    def __init__(self, database: Database, item: Input) -> None:
        self._database, self._item = database, item

    @cached_property
    def properties(self) -> Mapping[str, tuple[str, str]]:
        def read(tx: Transaction) -> Mapping[str, tuple[str, str]]:
            then, stored = find_document(tx, self._item)
            head = to_head(then.heads.document(stored), stored.frame_time)
            return {name: (value, unit) for name, value, unit in head.properties}

        return self._database.ask(read)

    def measure(self, source: EventSource) -> Trial:
        def measure(tx: Transaction) -> Trial:
            then, stored = find_document(tx, self._item)
            (body,) = read_bodies(then, [cast("Listed", stored)]).values()
            return measure_trial(then, stored, body, (), source, {})

        return self._database.ask(measure)


def list_trials(database: Database, inputs: Sequence[Input]) -> list[StoredTrial]:
    """The trials in the order of their document ids."""
    return [StoredTrial(database, item) for item in sorted(inputs, key=lambda item: str(item["document"]))]
