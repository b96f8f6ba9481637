"""What happened since somebody last looked: revisions that were made, comments, jobs that went on."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import timedelta
from typing import TypeAlias

from mcml_schemas.team.activity import ActivityEvent
from mcml_schemas.team.events import DocumentEvent
from mcml_service.actions.reading.tell_event import tell_event
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.jobs import StoredJob

MOST_BEHIND = 10_000
"""Commits that are told one by one; who has missed more reads anew."""

AT_A_TIME = 500
CLOCKS_APART = 10.0
"""Seconds by which clocks of servers on one store may differ."""
LABELLING = ("label", "unlabel")
Told: TypeAlias = dict[str, tuple[str, str, float, bool]]
"""State, stage, share and whether it shall end, of jobs by their ids."""


@dataclass
class News:
    """What somebody knows. commit, event: the last ones that were told. time: since when jobs may have ended that were
    not told.

    jobs: how each was that was told. missed: more happened than is told.
    """

    commit: int
    time: str
    event: int
    jobs: Told = field(default_factory=dict)
    missed: bool = False

    def revisions(self, tx: Transaction) -> list[DocumentEvent]:
        """Those made since, the oldest first, some hundred at a time."""
        newest = tx.newest_commit()
        self.missed = newest - self.commit > MOST_BEHIND
        if self.missed or newest == self.commit:
            self.commit = newest
            return []
        news = tx.revisions.since(self.commit, AT_A_TIME)
        self.commit = max((number for number, _ in news), default=newest) if len(news) >= AT_A_TIME else newest
        return [
            DocumentEvent(
                document=uuid,
                revision=item.number,
                operation=item.operation,
                name=item.name,
                project=item.project,
                author=item.author,
                time=item.time,
            )
            for _, (uuid, item) in news
        ]

    def comments(self, tx: Transaction) -> list[ActivityEvent]:
        """What was done with comments since, the oldest first, some hundred at a time."""
        newest = tx.activity.newest()
        if newest <= self.event:
            return []
        news = tx.activity.after(self.event, AT_A_TIME, kind="comment")
        self.event = news[-1].number if len(news) == AT_A_TIME else newest
        return [tell_event(event) for event in news]

    def find_changed_jobs(self, tx: Transaction) -> list[StoredJob]:
        """Jobs that are in another state than was told, or further."""
        # Another server's clock may be behind, and what has ended is seen a little later.
        time, known = now(-timedelta(seconds=CLOCKS_APART)), self.jobs
        jobs = tx.jobs.active_or_ended_since(self.time)
        seen: Told = {job.uuid: (job.state, job.stage, job.share, job.cancel) for job in jobs}
        self.jobs, self.time = seen, time
        return [job for job in jobs if known.get(job.uuid) != seen[job.uuid]]
