"""What those ask for who draw a document: its skeleton."""

from __future__ import annotations

from schemas.skeletons import SkeletonView
from service.operations.arguments import AtRevision, DocumentId, at_revision, tag
from service.operations.call import Call


def get_skeleton(call: Call, id: DocumentId, revision: AtRevision = None) -> SkeletonView:
    """Bones with parents, sides, offsets, axes and channels; ends of chains; unit, up axis, rate and origin. With a
    `revision` the answer never changes, and says so.
    """
    # Imported here: other operations need no mathematics.
    from service.actions.reading.describe_skeleton import describe_skeleton

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        call.tagged(tag(stored, "skeleton"), lasting=revision is not None)
        return describe_skeleton(then, stored)
