"""A stored document as the wire shows it."""

from __future__ import annotations

import json

from mcml.language.elements import to_head
from mcml_schemas.documents import Bone, DocumentDetail, DocumentSummary, Label, Property, Receipt, StoredFile
from mcml_schemas.media import MediaInfo
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.media import StoredMedia
from mcml_service.storage.transaction import Transaction


def summary(stored: StoredDocument) -> DocumentSummary:
    seconds = stored.seconds_per_frame
    return DocumentSummary(
        id=stored.uuid,
        name=stored.name,
        project=stored.project,
        format=stored.format,
        frames=stored.frames,
        seconds_per_frame=seconds,
        duration=None if seconds is None else stored.frames * seconds,
        skeleton=stored.skeleton,
        revision=stored.revision,
        created=stored.created,
        modified=stored.modified,
    )


def detail(tx: Transaction, stored: StoredDocument) -> DocumentDetail:
    head = to_head(tx.heads.document(stored), stored.frame_time)
    joints = head.skeleton.joints
    address = f"/api/v1/documents/{stored.uuid}"
    fields = summary(stored).model_dump()
    return DocumentDetail(
        **fields,
        description=head.description,
        properties=[Property(name=name, value=value, unit=unit) for name, value, unit in head.properties],
        unit=head.fields.get("calibration_unit"),
        up=head.fields.get("global_axis_of_gravity"),
        header=head.fields,
        bones=[
            Bone(
                name=joint.name,
                source_name=joint.source_name,
                parent=joints[joint.parent].name if joint.parent >= 0 else None,
                mapped=joint.mapped,
                role=joint.role,
                channels=list(joint.channels),
                rotation_order=joint.rotation_order,
                convention=joint.convention.value,
            )
            for joint in joints
        ],
        labels=[
            Label(id=span.key, name=span.name, first=span.first, last=span.last, rank=span.rank)
            for span in tx.spans.of(stored.key)
        ],
        files=[
            StoredFile(part=kept.part, name=kept.file_name, bytes=kept.size, sha256=kept.sha256)
            for kept in tx.uploads.of(stored.key)
        ],
        original=stored.intact and bool(tx.uploads.of(stored.key)),
        media=_media(tx, stored),
        receipt=Receipt(**json.loads(tx.documents.receipt(stored.key))),
        links={
            "mcml": f"{address}/mcml",
            "export": f"{address}/export?format={stored.format}",
            "frames": f"{address}/frames",
            "labels": f"{address}/labels",
            "revisions": f"{address}/revisions",
            "calibration": f"{address}/calibration",
        },
    )


def _media(tx: Transaction, stored: StoredDocument) -> MediaInfo | None:
    media = tx.media.of(stored.key)
    return None if media is None else media_info(media)


def media_info(media: StoredMedia) -> MediaInfo:
    return MediaInfo(
        name=media.file_name,
        media_type=media.media_type,
        bytes=media.size,
        sha256=media.sha256,
        offset=media.offset,
    )
