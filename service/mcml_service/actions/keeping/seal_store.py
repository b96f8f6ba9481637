"""A store that had no checksums gets them. What differs from its kept uploads is told, and not read as if sound."""

from __future__ import annotations

import logging

from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import content, track
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.upkeep.sealing import seal_rows, spoil

log = logging.getLogger("mcml.store")


def seal_store(tx: Transaction) -> None:
    """Write the checksums of all rows of a store that had none.

    Before sums are written over what is there, it is compared with the uploads that are kept: what differs is told, and
    marked, so that nobody reads it as if it were sound.
    """
    seal_rows(tx)
    for difference in compare_all(tx, Settings()):
        for fault in difference.faults:
            log.warning("%s: %s", difference.name, fault)
        for chunk, bone in difference.chunks:
            spoil(tx, track, document=difference.key, chunk=chunk, bone=bone, from_commit=0)
        if difference.faults and not difference.chunks:
            spoil(tx, content, document=difference.key)
