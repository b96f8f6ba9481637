"""Every table of the store: the only place that defines columns.

Rows that belong to revisions carry `from_commit` and `to_commit`: they are valid at commit n where
`from_commit <= n < to_commit`. `CURRENT` as `to_commit` means: still valid. Rows written by an import have
`from_commit` 0, for their document itself appears only with its `created_commit`.

Frames have two numberings. A *position* counts the frames of the document as XPath does, from 1. A *slot* is the place
of the frame's values: chunk * CHUNK + offset, from 0. `timeline` maps positions to slots, so cutting and inserting
never moves values.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    SmallInteger,
    String,
    Table,
    Text,
    UniqueConstraint,
    literal_column,
)

from mcml_service.storage.core.schema import CHANNEL_ENDS, CURRENT, KEY, NAME, checksum, cover, metadata

store = Table(
    "store",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("value", Text, nullable=False),
)
"""Values that a program must match to read the store (`mcml_service.storage.layout`); retired keys; the commit since
which the history is complete.
"""

project = Table(
    "project",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", NAME, nullable=False, unique=True),
    Column("created", String(32), nullable=False),
    checksum(),
    info=cover("name", "created"),
)

token = Table(
    "token",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", NAME, nullable=False, unique=True),
    Column("sha256", String(64), nullable=False, unique=True),
    Column("hint", String(16), nullable=False),
    Column("created", String(32), nullable=False),
    Column("expires", String(32)),
    checksum(),
    info=cover("name", "sha256", "hint", "created", "expires"),
)

commit = Table(
    "commit",
    metadata,
    Column("number", KEY, primary_key=True),
    Column("time", String(32), nullable=False),
    Column("author", NAME, nullable=False),
    checksum(),
    info=cover("number", "time", "author"),
)

document = Table(
    "document",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("uuid", String(36), nullable=False, unique=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("state", String(16), nullable=False),
    Column("lease", Float),
    Column("name", NAME, nullable=False),
    Column("format", String(32), nullable=False),
    Column("created_commit", BigInteger),
    Column("deleted_commit", BigInteger, nullable=False),
    Column("next_slot", BigInteger, nullable=False),
    Column("receipt", LargeBinary, nullable=False),
    checksum(),
    Index(None, "project", "name"),
    Index("ix_document_there", "name", "state", "deleted_commit", "created_commit"),
    info=cover("uuid", "project", "state", "name", "format", "created_commit", "deleted_commit", "next_slot"),
)
"""`ix_document_there`: existing documents by name, without their receipts."""


revision = Table(
    "revision",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("commit", ForeignKey("commit.number"), nullable=False, index=True),
    Column("parent", Integer),
    Column("operation", String(32), nullable=False),
    Column("message", Text, nullable=False),
    Column("name", NAME, nullable=False),
    Column("project", ForeignKey("project.id"), nullable=False),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "number", "commit", "parent", "operation", "message", "name", "project"),
)
"""`name`, `project`: the values of the document after this revision; the row of the document has the current ones."""

skeleton = Table(
    "skeleton",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("hash", String(64), nullable=False),
    Column("joints", Integer, nullable=False),
    checksum(),
    UniqueConstraint("project", "hash"),
    info=cover("project", "hash", "joints"),
)

skeleton_element = Table(
    "skeleton_element",
    metadata,
    Column("skeleton", ForeignKey("skeleton.id"), primary_key=True),
    Column("pre", Integer, primary_key=True),
    Column("size", Integer, nullable=False),
    Column("level", SmallInteger, nullable=False),
    Column("tag", String(32), nullable=False),
    Column("attributes", Text, nullable=False),
    Column("text", Text, nullable=False),
    sqlite_with_rowid=False,
)

content = Table(
    "content",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("skeleton", ForeignKey("skeleton.id"), nullable=False),
    Column("version", String(32), nullable=False),
    Column("frames", BigInteger, nullable=False),
    Column("frame_time", String(64)),
    Column("intact", Boolean, nullable=False),
    checksum(),
    Index(None, "skeleton"),
    sqlite_with_rowid=False,
    info=cover("document", "skeleton", "version", "frames", "frame_time", "intact", last=bool),
)
"""Values with one entry for each revision.

`intact`: everything that the source format can hold is unchanged, so an export in that format may return the uploaded
bytes.
"""

header = Table(
    "header",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("pre", Integer, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("size", Integer, nullable=False),
    Column("level", SmallInteger, nullable=False),
    Column("tag", String(32), nullable=False),
    Column("attributes", Text, nullable=False),
    Column("text", Text, nullable=False),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "pre", "size", "level", "tag", "attributes", "text"),
)

property_ = Table(
    "property",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("name", NAME, primary_key=True),
    Column("number", Float),
    Column("text", Text, nullable=False),
    Column("unit", String(64), nullable=False),
    checksum(),
    Index(None, "name", "number"),
    sqlite_with_rowid=False,
    info=cover("document", "name", "text", "unit"),
)
"""The property elements of current headers again, for search."""

bone = Table(
    "bone",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("bone", Integer, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("name", NAME, nullable=False),
    checksum(),
    Index(None, "name", "document"),
    sqlite_with_rowid=False,
    info=cover("document", "bone", "name"),
)

timeline = Table(
    "timeline",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("first", BigInteger, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("slot", BigInteger, nullable=False),
    Column("count", BigInteger, nullable=False),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "first", "slot", "count"),
)

frame_run = Table(
    "frame_run",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("first", BigInteger, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("count", BigInteger, nullable=False),
    Column("first_id", BigInteger),
    Column("step", BigInteger),
    Column("texts", Text),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "first", "count", "first_id", "step", "texts"),
)

shape = Table(
    "shape",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("shape", Integer, primary_key=True),
    Column("bones", LargeBinary, nullable=False),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "shape", "bones", last=bytes),
)
"""`bones`: pairs of little-endian 16-bit numbers (bone, channel bits), in the order of the frame_bones."""

shape_run = Table(
    "shape_run",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("slot", BigInteger, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("count", BigInteger, nullable=False),
    Column("shape", Integer, nullable=False),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "slot", "count", "shape"),
)

span = Table(
    "span",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("document", ForeignKey("document.id"), nullable=False),
    Column("from_commit", BigInteger, nullable=False),
    Column("to_commit", BigInteger, nullable=False),
    Column("name", NAME, nullable=False),
    Column("first", BigInteger, nullable=False),
    Column("last", BigInteger, nullable=False),
    Column("rank", Integer, nullable=False),
    checksum(),
    Index(None, "name", "document"),
    Index(None, "document", "first"),
    info=cover("document", "name", "first", "last", "rank"),
)

track = Table(
    "track",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("chunk", Integer, primary_key=True),
    Column("bone", Integer, primary_key=True),
    Column("from_commit", BigInteger, primary_key=True),
    Column("to_commit", BigInteger, nullable=False),
    Column("count", SmallInteger, nullable=False),
    Column("channels", SmallInteger, nullable=False),
    Column("has_missing", SmallInteger, nullable=False),
    *(Column(end, Float(53)) for end in CHANNEL_ENDS),
    Column("codec", SmallInteger, nullable=False),
    Column("data", LargeBinary, nullable=False),
    checksum("data_checksum"),
    checksum(),
)
"""`channels`, `has_missing`: bit i is for `CHANNELS[i]`.

The zone map (min, max) covers the samples present. `data_checksum` is that of the data, `checksum` of all other
columns.
"""

CLOSED_TRACK = track.c.to_commit < literal_column(str(CURRENT))
"""The exact condition with which a query finds past tracks by `to_commit` with the partial index: it has only past
tracks, so an import writes nothing into it.
"""
Index("ix_track_closed", track.c.document, track.c.to_commit, sqlite_where=CLOSED_TRACK, postgresql_where=CLOSED_TRACK)

thumbnail = Table(
    "thumbnail",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("revision", Integer, primary_key=True),
    Column("facts", Text, nullable=False),
    Column("data", LargeBinary, nullable=False),
    checksum(),
    info=cover("document", "revision", "facts", "data", last=bytes),
)
"""`data`: in the format of `mcml.motion.pictures.thumbnails`; empty: nothing can be drawn.

`facts`: JSON, the guesses.
"""

body = Table(
    "body",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("revision", Integer, primary_key=True),
    Column("block", Integer, primary_key=True),
    Column("facts", Text, nullable=False),
    Column("data", LargeBinary, nullable=False),
    checksum(),
    info=cover("document", "revision", "block", "facts", "data", last=bytes),
)
"""`data`: positions of joints, in the format of `storage.steps`. `facts`: JSON of block 0, the calibration."""

upload = Table(
    "upload",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False, index=True),
    Column("size", BigInteger, nullable=False),
    Column("complete", Boolean, nullable=False),
    Column("lease", Float),
    Column("vertices", Integer),
)
"""`vertices`: of the skinned meshes in the file; 0: it has none; NULL: nobody has looked yet."""

upload_block = Table(
    "upload_block",
    metadata,
    Column("upload", ForeignKey("upload.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("data", LargeBinary, nullable=False),
    checksum(),
    info=cover("upload", "number", "data", last=bytes),
)

document_media = Table(
    "document_media",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("upload", ForeignKey("upload.id"), nullable=False, index=True),
    Column("file_name", NAME, nullable=False),
    Column("media_type", String(64), nullable=False),
    Column("offset", Float(53), nullable=False),
    checksum(),
    info=cover("document", "upload", "file_name", "media_type", "offset"),
)
"""Video or audio for reference. `offset`: seconds in it at the first frame."""

document_upload = Table(
    "document_upload",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("part", String(16), primary_key=True),
    Column("file_name", NAME, nullable=False),
    Column("upload", ForeignKey("upload.id"), nullable=False, index=True),
    checksum(),
    sqlite_with_rowid=False,
    info=cover("document", "part", "file_name", "upload"),
)

REVISIONED = (content, header, bone, timeline, frame_run, shape_run, span, track)
"""Tables whose rows are valid between commits."""
