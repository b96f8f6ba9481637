"""Every table of the store: the only place that spells columns.

Rows that belong to revisions carry `from_commit` and `to_commit`: they are valid at commit n where
`from_commit <= n < to_commit`. `CURRENT` as `to_commit` means: still valid. Rows written by an import have
`from_commit` 0, for their document itself appears only with its `created_commit`.

Frames have two numberings. A *position* counts the frames of the document as XPath does, from 1. A *slot* is where
the frame's values lie: chunk * CHUNK + offset, from 0. `timeline` maps positions to slots, so cutting and inserting
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
    MetaData,
    SmallInteger,
    String,
    Table,
    Text,
    UniqueConstraint,
    literal_column,
)

from service.motion.skeleton import CHANNELS

CHUNK = 256
"""Frames in one track row."""

CURRENT = 2**63 - 1
"""`to_commit` of rows that no later commit has closed."""

NAME = String(1024).with_variant(String(1024, collation="C"), "postgresql")
"""Names compare by code point in every database, as XPath's string comparison does."""

KEY = BigInteger().with_variant(Integer, "sqlite")
"""SQLite numbers rows by itself only in a column typed INTEGER."""

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)


project = Table(
    "project",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", NAME, nullable=False, unique=True),
    Column("created", String(32), nullable=False),
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
)

commit = Table(
    "commit",
    metadata,
    Column("number", KEY, primary_key=True),
    Column("time", String(32), nullable=False),
    Column("author", NAME, nullable=False),
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
    Index(None, "project", "name"),
)

revision = Table(
    "revision",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("commit", ForeignKey("commit.number"), nullable=False),
    Column("parent", Integer),
    Column("operation", String(32), nullable=False),
    Column("message", Text, nullable=False),
    Column("name", NAME, nullable=False),
    Column("project", ForeignKey("project.id"), nullable=False),
    sqlite_with_rowid=False,
)
"""`name`, `project`: what the revision left in the row of the document, which has the present ones."""

skeleton = Table(
    "skeleton",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("hash", String(64), nullable=False),
    Column("joints", Integer, nullable=False),
    UniqueConstraint("project", "hash"),
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
    Index(None, "skeleton"),
    sqlite_with_rowid=False,
)
"""What is one value a revision. `intact`: all that the source format holds is as it was uploaded, so an export in that
format may answer the kept bytes."""

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
    sqlite_with_rowid=False,
)

property_ = Table(
    "property",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("name", NAME, primary_key=True),
    Column("number", Float),
    Column("text", Text, nullable=False),
    Column("unit", String(64), nullable=False),
    Index(None, "name", "number"),
    sqlite_with_rowid=False,
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
    Index(None, "name", "document"),
    sqlite_with_rowid=False,
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
    sqlite_with_rowid=False,
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
    sqlite_with_rowid=False,
)

shape = Table(
    "shape",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("shape", Integer, primary_key=True),
    Column("bones", LargeBinary, nullable=False),
    sqlite_with_rowid=False,
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
    sqlite_with_rowid=False,
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
    Index(None, "name", "document"),
    Index(None, "document", "first"),
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
    *(Column(f"{end}_{channel}", Float(53)) for channel in CHANNELS for end in ("min", "max")),
    Column("codec", SmallInteger, nullable=False),
    Column("data", LargeBinary, nullable=False),
)
"""`channels`, `has_missing`: bit i stands for `CHANNELS[i]`. The zone map (min, max) covers the samples present."""

CLOSED_TRACK = track.c.to_commit < literal_column(str(CURRENT))
"""What a query must say, word for word, to find tracks of the past by `to_commit` without reading all: the index holds
those alone, so an import writes nothing into it."""
Index("ix_track_closed", track.c.document, track.c.to_commit, sqlite_where=CLOSED_TRACK, postgresql_where=CLOSED_TRACK)

upload = Table(
    "upload",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False, index=True),
    Column("size", BigInteger, nullable=False),
    Column("complete", Boolean, nullable=False),
    Column("lease", Float),
)

upload_block = Table(
    "upload_block",
    metadata,
    Column("upload", ForeignKey("upload.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("data", LargeBinary, nullable=False),
)

document_upload = Table(
    "document_upload",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("part", String(16), primary_key=True),
    Column("file_name", NAME, nullable=False),
    Column("upload", ForeignKey("upload.id"), nullable=False, index=True),
    sqlite_with_rowid=False,
)

joint_mapping = Table(
    "joint_mapping",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("name", NAME, nullable=False),
    Column("version", Integer, nullable=False),
    Column("author", NAME, nullable=False),
    Column("changed", String(32), nullable=False),
    Column("pairs", Text, nullable=False),
    UniqueConstraint("project", "name"),
)
"""Which joint of a source is which of a target, under a name. `pairs`: JSON, [[source, target], …]."""

joint_alias = Table(
    "joint_alias",
    metadata,
    Column("project", ForeignKey("project.id"), primary_key=True),
    *(Column(name, joint_mapping.c[name].type, nullable=False) for name in ("version", "author", "changed", "pairs")),
)
"""What a project calls joints, beside the names that are known. `pairs`: JSON, [[name in files, MCML's name], …]."""

job = Table(
    "job",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("uuid", String(36), nullable=False, unique=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("analysis", String(64), nullable=False),
    Column("name", NAME, nullable=False),
    Column("owner", NAME, nullable=False),
    Column("state", String(16), nullable=False),
    Column("inputs", Text, nullable=False),
    Column("parameters", Text, nullable=False),
    Column("stage", String(256), nullable=False),
    Column("share", Float, nullable=False),
    Column("attempt", Integer, nullable=False),
    Column("runner", String(64)),
    Column("lease", Float),
    Column("cancel", Boolean, nullable=False),
    Column("created", String(32), nullable=False),
    Column("started", String(32)),
    Column("ended", String(32)),
    Column("problem", Text),
    Column("result", ForeignKey("result.id")),
    Index(None, "state"),
    Index(None, "project"),
)
"""`state`: waiting, running, done, failed, cancelled. `inputs`, `parameters`, `problem`: JSON. `runner`, `lease`: who
works on it, and until when that may be believed without news."""

result = Table(
    "result",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("uuid", String(36), nullable=False, unique=True),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("parent", ForeignKey("result.id")),
    Column("analysis", String(64), nullable=False),
    Column("name", NAME, nullable=False),
    Column("owner", NAME, nullable=False),
    Column("inputs", Text, nullable=False),
    Column("parameters", Text, nullable=False),
    Column("made_with", Text, nullable=False),
    Column("created", String(32), nullable=False),
    Index(None, "project"),
    Index(None, "parent"),
)
"""`parent`: the result from which an operation made this one. `inputs`: documents with the revisions that were read.
`made_with`: versions of the libraries that computed it."""

result_part = Table(
    "result_part",
    metadata,
    Column("result", ForeignKey("result.id"), primary_key=True),
    Column("name", String(64), primary_key=True),
    Column("kind", String(16), nullable=False),
    Column("data", LargeBinary, nullable=False),
    Column("arrays", Text, nullable=False),
    Column("document", ForeignKey("document.id")),
)
"""`data`: JSON. `arrays`: name -> type and shape of what lies in `result_block`. `document`: the clip of a part that is
one."""

result_block = Table(
    "result_block",
    metadata,
    Column("result", ForeignKey("result.id"), primary_key=True),
    Column("part", String(64), primary_key=True),
    Column("array", String(64), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("data", LargeBinary, nullable=False),
)
