"""Webhooks, and the messages sent to them."""

from __future__ import annotations

import base64
import json
import random
import secrets
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import (
    Select,
    and_,
    delete,
    exists,
    insert,
    select,
    update,
)

from mcml.errors import AccessError, NotFoundError
from mcml_service.storage.core.identifiers import new_uuid, now
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import SCOPES, may
from mcml_service.storage.projects.activity import Activity, Event
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.team.tables import delivery, webhook

RETRY_SECONDS: Final = (5, 300, 1800, 7200, 18_000, 36_000, 50_400, 72_000, 86_400)
"""How long after each attempt that failed the next one follows; then the message has failed."""

LEASE_SECONDS = 120.0
"""After so long a message whose sender is silent may be sent by another one."""

GONE = 410
"""The answer of an endpoint that wants no more messages."""

AT_A_TIME = 500


@dataclass(frozen=True)
class Webhook:
    """project: None for the whole repository. kinds: of events, () for all. ended: since when it wants no more."""

    number: int
    project: str | None
    url: str
    kinds: tuple[str, ...]
    author: str
    created: str
    ended: str | None


@dataclass(frozen=True)
class Delivery:
    """A message. attempts: that were made, or begun. status, problem: of the last one."""

    number: int
    message: str
    type: str
    created: str
    state: str
    attempts: int
    status: int | None
    problem: str | None


@dataclass(frozen=True)
class Claimed:
    """A message to be sent now. attempt: which one this is, from 1."""

    number: int
    url: str
    secret: str
    message: str
    payload: str
    attempt: int


class Webhooks:
    def __init__(self, tx: BaseTransaction, activity: Activity, projects: Projects, quotas: Quotas) -> None:
        self._tx = tx
        self._activity = activity
        self._projects = projects
        self._quotas = quotas

    def all(self, project_key: int | None = None) -> list[Webhook]:
        """Those of projects that one owns, the newest first; of one project alone."""
        query = _TOLD.order_by(webhook.c.id.desc())
        if project_key is not None:
            query = query.where(webhook.c.project == project_key)
        rows = [row for row in self._tx.fetch_all(query) if self._decides(row.key)]
        return [
            Webhook(row.id, row.name, row.url, tuple(row.kinds.split()), row.author, row.created, row.ended)
            for row in rows
        ]

    def add(self, url: str, kinds: Iterable[str], project_key: int | None) -> tuple[str, Webhook]:
        """Add a webhook; return its secret and its data. It receives events from now on. Raises AccessError."""
        if project_key is not None:
            self._quotas.require(project_key, "own")
        elif not self._decides(None):
            raise AccessError("Only owners of the repository hear of all of it.", remedy="Name a project that you own.")
        self._tx.order()
        secret = "whsec_" + base64.b64encode(secrets.token_bytes(32)).decode()
        about = {"project": project_key, "url": url, "kinds": " ".join(kinds), "secret": secret}
        values = {"author": self._tx.author, "created": now(), "after": self._activity.newest()}
        number = self._tx.insert_row(webhook, **about, **values)
        self._activity.note("webhook", "add", project_key=project_key, subject=str(number))
        return secret, self.get(number)

    def get(self, number: int) -> Webhook:
        """NotFoundError."""
        current = next((hook for hook in self.all() if hook.number == number), None)
        if current is None:
            raise NotFoundError(f"There is no webhook {number}.", remedy="List those that there are.")
        return current

    def remove(self, number: int) -> None:
        """Nothing is sent there any more. NotFoundError."""
        current = self.get(number)
        self._tx.run(delete(delivery).where(delivery.c.webhook == number))
        self._tx.run(delete(webhook).where(webhook.c.id == number))
        key = None if current.project is None else self._projects.get(current.project)
        self._activity.note("webhook", "remove", project_key=key, subject=str(number))

    def deliveries(self, number: int, before: int | None, limit: int) -> list[Delivery]:
        """Messages of a webhook that one sees, the newest first, those with numbers below `before`."""
        query = select(*_LOGGED).where(delivery.c.webhook == number).order_by(delivery.c.id.desc()).limit(limit)
        if before is not None:
            query = query.where(delivery.c.id < before)
        return [Delivery(*row) for row in self._tx.fetch_all(query)]

    def send_again(self, number: int, message: int) -> Delivery:
        """Let a message be sent once more, at once, as if for the first time. NotFoundError."""
        self.get(number)
        its = and_(delivery.c.id == message, delivery.c.webhook == number)
        anew = {"state": "waiting", "attempts": 0, "due": time.time()}
        if not self._tx.run(update(delivery).where(its).values(**anew)):
            raise NotFoundError(f"Webhook {number} has no message {message}.", remedy="See its log.")
        (row,) = self._tx.fetch_all(select(*_LOGGED).where(its))
        return Delivery(*row)

    def _decides(self, project_key: int | None) -> bool:
        view = self._tx.view
        return may(view.everywhere, SCOPES[-1]) if project_key is None else may(view.scope(project_key), "own")

    # Automatic actions of a server.

    def any_due(self) -> bool:
        """Whether `queue` or `claim` would find anything; a cheap read."""
        news = exists().where(webhook.c.ended.is_(None), webhook.c.after < self._activity.newest())
        return bool(self._tx.fetch_value(select(news | exists().where(_due()))))

    def queue(self) -> None:
        """Make messages of the events that webhooks have not heard of."""
        newest = self._activity.newest()
        behind = select(webhook).where(webhook.c.ended.is_(None), webhook.c.after < newest)
        for row in self._tx.fetch_all(behind.with_for_update(skip_locked=True)):
            events = self._activity.after(row.after, AT_A_TIME, project_key=row.project)
            heard = events[-1].number if len(events) == AT_A_TIME else newest
            wanted = [event for event in events if not row.kinds or event.kind in row.kinds.split()]
            if wanted:
                self._tx.run(insert(delivery), [_message(row.id, event) for event in wanted])
            self._tx.run(update(webhook).where(webhook.c.id == row.id).values(after=heard))

    def claim(self, most: int) -> list[Claimed]:
        """Claim up to `most` due messages, the oldest first."""
        query = (
            select(delivery.c.id, webhook.c.url, webhook.c.secret, delivery.c.message, delivery.c.payload)
            .add_columns(delivery.c.attempts + 1)
            .join(webhook, webhook.c.id == delivery.c.webhook)
            .where(_due())
            .order_by(delivery.c.due)
            .limit(most)
        )
        rows = self._tx.fetch_all(query.with_for_update(skip_locked=True, of=delivery))
        for row in rows:
            begun = {"attempts": row[-1], "due": time.time() + LEASE_SECONDS}
            self._tx.run(update(delivery).where(delivery.c.id == row[0]).values(**begun))
        return [Claimed(*row) for row in rows]

    def note_outcome(self, claimed: Claimed, status: int | None, problem: str | None, patience: float = 0.0) -> None:
        """Note what came of an attempt, unless another one was begun since. problem: None for success. patience:
        seconds for which who answered wants to be left alone."""
        its = and_(delivery.c.id == claimed.number, delivery.c.attempts == claimed.attempt)
        values: dict[str, Any] = {"status": status, "problem": problem and problem[:256]}
        if problem is None:
            values["state"] = "sent"
        elif claimed.attempt > len(RETRY_SECONDS) or status == GONE:
            values["state"] = "failed"
        else:
            pause = RETRY_SECONDS[claimed.attempt - 1] * random.uniform(1, 1.2)
            values["due"] = time.time() + max(pause, min(patience, RETRY_SECONDS[-1]))
        changed = self._tx.run(update(delivery).where(its).values(**values))
        if changed and status == GONE:
            whose = select(delivery.c.webhook).where(its).scalar_subquery()
            self._tx.run(update(webhook).where(webhook.c.id == whose).values(ended=now()))
            rest = and_(delivery.c.webhook == whose, delivery.c.state == "waiting")
            self._tx.run(update(delivery).where(rest).values(state="failed", problem="gone"))

    def forget(self, before: str) -> None:
        """Remove messages from before a time that wait no more."""
        old = and_(delivery.c.created < before, delivery.c.state != "waiting")
        self._tx.run(delete(delivery).where(old))


_TOLD: Select[Any] = select(
    *(webhook.c.id, project.c.name, webhook.c.url, webhook.c.kinds, webhook.c.author, webhook.c.created),
    *(webhook.c.ended, webhook.c.project.label("key")),
).outerjoin(project, project.c.id == webhook.c.project)
_LOGGED = (
    *(delivery.c.id, delivery.c.message, delivery.c.type, delivery.c.created, delivery.c.state),
    *(delivery.c.attempts, delivery.c.status, delivery.c.problem),
)
"""The columns of a Delivery."""


def _due() -> Any:
    return and_(delivery.c.state == "waiting", delivery.c.due <= time.time())


def _message(number: int, event: Event) -> dict[str, Any]:
    """A message as a row. It names no document, so that a purge need not look for it."""
    told = ("kind", "what", "author", "project", "document", "revision", "subject")
    type_ = f"{event.kind}.{event.what}"
    data = {"id": event.number, **{name: getattr(event, name) for name in told}}
    payload = json.dumps({"type": type_, "timestamp": event.time, "data": data}, separators=(",", ":"))
    message = {"message": f"msg_{new_uuid().replace('-', '')}", "type": type_, "payload": payload}
    return {"webhook": number, **message, "created": now(), "state": "waiting", "attempts": 0, "due": time.time()}
