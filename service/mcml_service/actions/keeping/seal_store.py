"""Add checksums to a store without them.

Documents that differ from their uploaded files are reported, and marked as damaged.
"""

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

    Before this, its content is compared with the uploaded files: differences are reported and marked, so that they are
    not read as valid.
    """
    seal_rows(tx)
    for difference in compare_all(tx, Settings()):
        for fault in difference.faults:
            log.warning("%s: %s", difference.name, fault)
        for chunk, bone in difference.chunks:
            spoil(tx, track, document=difference.key, chunk=chunk, bone=bone, from_commit=0)
        if difference.faults and not difference.chunks:
            spoil(tx, content, document=difference.key)
