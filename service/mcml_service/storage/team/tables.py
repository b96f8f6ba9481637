"""Tables of people: accounts, credentials, links, and temporary rows. Most have no checksums."""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    String,
    Table,
    Text,
    UniqueConstraint,
)

from mcml_service.storage.core.schema import KEY, NAME, metadata

account = Table(
    "account",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", NAME, nullable=False),
    Column("role", String(16), nullable=False),
    Column("password", Text, nullable=False),
    Column("created", String(32), nullable=False),
    Column("closed", String(32)),
    UniqueConstraint("name"),
)
"""`password`: its Argon2 hash. `closed`: since when the account opens nothing; its name stays taken, as revisions carry
it."""

invitation = Table(
    "invitation",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("role", String(16), nullable=False),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("expires", String(32), nullable=False),
    Column("project", ForeignKey("project.id")),
    UniqueConstraint("sha256"),
)
"""`author`: the inviting person. `project`: the only project of the role. The new account uses it up."""

grant = Table(
    "token_grant",
    metadata,
    Column("token", ForeignKey("token.id"), primary_key=True),
    Column("scope", String(16), nullable=False),
    Column("account", ForeignKey("account.id")),
    Column("used", String(32)),
)
"""Rights of tokens; a token without a row gives no access.

`account`: its owner; the token never has more rights, and ends with the account. `used`: approximate time of the last
use.
"""

granted_project = Table(
    "token_project",
    metadata,
    Column("token", ForeignKey("token.id"), primary_key=True),
    Column("project", ForeignKey("project.id"), primary_key=True),
)
"""Where a token opens something; everywhere, where it has no rows."""

identity = Table(
    "identity",
    metadata,
    Column("issuer", String(512), primary_key=True),
    Column("subject", String(255), primary_key=True),
    Column("account", ForeignKey("account.id"), nullable=False),
)
"""Whom a provider of OpenID Connect knows as `subject`."""

membership = Table(
    "membership",
    metadata,
    Column("account", ForeignKey("account.id"), primary_key=True),
    Column("project", ForeignKey("project.id"), primary_key=True),
    Column("role", String(16), nullable=False),
)

presence = Table(
    "presence",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("document", ForeignKey("document.id"), nullable=False, index=True),
    Column("account", ForeignKey("account.id"), nullable=False),
    Column("tab", String(36), nullable=False),
    Column("doing", String(16), nullable=False),
    Column("since", String(32), nullable=False),
    Column("expires", Float(53), nullable=False),
)
"""`tab`: which of several windows of a person. `expires`: seconds since 1970."""

share = Table(
    "share",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("name", NAME, nullable=False),
    Column("project", ForeignKey("project.id"), nullable=False),
    Column("formats", String(256), nullable=False),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("expires", String(32), nullable=False),
    UniqueConstraint("sha256"),
)
"""`formats`: allowed export formats, separated by spaces."""

shared_document = Table(
    "shared_document",
    metadata,
    Column("share", ForeignKey("share.id"), primary_key=True),
    Column("document", ForeignKey("document.id"), primary_key=True),
    Column("revision", Integer, nullable=False),
    Column("latest", Boolean, nullable=False),
)
"""`revision`: the current one when the link was made.

`latest`: whether later ones are shown too, the last one by default.
"""

session = Table(
    "session",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("kind", String(16), nullable=False),
    Column("author", NAME, nullable=False),
    Column("token", ForeignKey("token.id")),
    Column("account", ForeignKey("account.id")),
    Column("share", ForeignKey("share.id")),
    Column("created", String(32), nullable=False),
    Column("expires", String(32), nullable=False),
    UniqueConstraint("sha256"),
)
"""`kind`: session; link, which becomes a session, once; or share.

`token`, `share`: the credential that was exchanged for it; it ends with that. `account`: its owner.
"""

request = Table(
    "request",
    metadata,
    Column("author", NAME, primary_key=True),
    Column("key", String(255), primary_key=True),
    Column("operation", String(64), nullable=False),
    Column("digest", String(64), nullable=False),
    Column("created", String(32), nullable=False),
    Column("status", Integer),
    Column("location", Text),
    Column("answer", Text),
)
"""`digest`: of the request. `status`: null while the request runs, or permanently if the server crashed meanwhile."""

attempt = Table(
    "attempt",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("expires", Float(53), nullable=False),
    Index(None, "sha256", "expires"),
)
"""`sha256`: of the counted address or name, never of the guessed secret. `expires`: seconds since 1970."""

webhook = Table(
    "webhook",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("project", ForeignKey("project.id")),
    Column("url", Text, nullable=False),
    Column("kinds", String(256), nullable=False),
    Column("secret", String(128), nullable=False),
    Column("author", NAME, nullable=False),
    Column("created", String(32), nullable=False),
    Column("after", BigInteger, nullable=False),
    Column("ended", String(32)),
)
"""`project`: null for the whole repository. `kinds`: of events, with spaces between; empty for all. `secret`: in clear,
for messages are signed with it. `after`: the last event that was looked at. `ended`: since when it wants no more."""

delivery = Table(
    "webhook_delivery",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("webhook", ForeignKey("webhook.id"), nullable=False, index=True),
    Column("message", String(64), nullable=False),
    Column("type", String(64), nullable=False),
    Column("payload", Text, nullable=False),
    Column("created", String(32), nullable=False),
    Column("state", String(16), nullable=False),
    Column("attempts", Integer, nullable=False),
    Column("due", Float(53), nullable=False),
    Column("status", Integer),
    Column("problem", String(256)),
    Index(None, "state", "due"),
)
"""`state`: waiting, sent, failed.

`due`: time in seconds since 1970 from which on it may be sent; a sender moves it forward, so that no other server sends
it meanwhile. `status`: of the last answer. `problem`: why the last attempt failed.
"""
