"""Tables of objects other than documents: mappings of joints, jobs, and results. `tables` has the documents."""

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
    String,
    Table,
    Text,
    UniqueConstraint,
)

from mcml_service.storage.core.schema import KEY, NAME, checksum, cover, metadata

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
    checksum(),
    UniqueConstraint("project", "name"),
    info=cover("project", "name", "version", "author", "changed", "pairs"),
)
"""Which joint of a source is which of a target, under a name. `pairs`: JSON, [[source, target], …]."""

joint_alias = Table(
    "joint_alias",
    metadata,
    Column("project", ForeignKey("project.id"), primary_key=True),
    *(Column(name, joint_mapping.c[name].type, nullable=False) for name in ("version", "author", "changed", "pairs")),
    checksum(),
    info=cover("project", "version", "author", "changed", "pairs"),
)
"""Aliases of joints in a project. `pairs`: JSON, [[name in files, MCML's name], …]."""

saved = Table(
    "saved",
    metadata,
    Column("project", ForeignKey("project.id"), primary_key=True),
    Column("kind", String(16), primary_key=True),
    Column("name", NAME, primary_key=True),
    Column("version", Integer, nullable=False),
    Column("author", NAME, nullable=False),
    Column("changed", String(32), nullable=False),
    Column("content", Text, nullable=False),
    checksum(),
    info=cover("project", "kind", "name", "version", "author", "changed", "content"),
)
"""Saved items of projects. `kind`: query, collection, colours, vocabulary. `content`: JSON."""

comment = Table(
    "comment",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("document", ForeignKey("document.id"), nullable=False, index=True),
    Column("revision", Integer, nullable=False),
    Column("first", BigInteger),
    Column("last", BigInteger),
    Column("bone", NAME),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("text", Text, nullable=False),
    Column("edited", String(32)),
    Column("resolved", String(32)),
    Column("deleted", String(32)),
    Column("proposal", Integer),
    checksum(),
    info=cover(
        *("document", "revision", "first", "last", "bone", "author", "created", "text", "edited", "resolved"),
        *("deleted", "proposal"),
        last=int,
    ),
)
"""`revision`: that was looked at. `first`, `last`: positions of frames there. The text of a deleted one is empty.
`proposal`: number of the proposal that it is about, null for the document itself."""

proposal = Table(
    "proposal",
    metadata,
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("revision", Integer, nullable=False),
    Column("kind", String(16), nullable=False),
    Column("content", Text, nullable=False),
    Column("inputs", Text, nullable=False),
    Column("summary", Text, nullable=False),
    Column("message", Text, nullable=False),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("state", String(16), nullable=False),
    Column("reviewer", NAME),
    Column("reviewed", String(32)),
    Column("closer", NAME),
    Column("closed", String(32)),
    Column("applied", Integer),
    checksum(),
    info=cover(
        *("document", "number", "revision", "kind", "content", "inputs", "summary", "message", "author", "created"),
        *("state", "reviewer", "reviewed", "closer", "closed", "applied"),
    ),
)
"""Proposed changes of documents. `number`: counts up in each document. `revision`: that the change was made for.

`kind`: frames, changes: the request in `content`, as JSON. `inputs`: JSON, revisions of other documents whose frames it
inserts, by id. `state`: open, approved, applied, closed. `closer`, `closed`: person and time of closing or applying it.
`applied`: the revision that it became.
"""

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
"""`state`: waiting, running, done, failed, cancelled.

`inputs`, `parameters`, `problem`: JSON. `runner`, `lease`: the runner, and the time until which it counts as alive
without news.
"""

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
    checksum(),
    Index(None, "project"),
    Index(None, "parent"),
    info=cover(
        "uuid", "project", "parent", "analysis", "name", "owner", "inputs", "parameters", "made_with", "created"
    ),
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
    checksum(),
    info=cover("result", "name", "kind", "arrays", "document", "data", last=bytes),
)
"""`data`: JSON.

`arrays`: name -> type and shape of the data in `result_block`. `document`: the document of a part that is a clip.
"""

result_block = Table(
    "result_block",
    metadata,
    Column("result", ForeignKey("result.id"), primary_key=True),
    Column("part", String(64), primary_key=True),
    Column("array", String(64), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("data", LargeBinary, nullable=False),
    checksum(),
    info=cover("result", "part", "array", "number", "data", last=bytes),
)
