"""Read news since the last read: new revisions, comments, proposals, progress of jobs."""

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
"""Limit of commits reported one by one; clients that missed more must read everything again."""

AT_A_TIME = 500
CLOCKS_APART = 10.0
"""Seconds by which clocks of servers on one store may differ."""
LABELLING = ("label", "unlabel")
Told: TypeAlias = dict[str, tuple[str, str, float, bool]]
"""State, stage, share and cancellation of jobs, by their ids."""


@dataclass
class News:
    """The position of a client in the news.

    commit, event: the last reported ones. time: since which ended jobs may not have been reported. jobs: the last
    reported state of each. missed: whether more happened than is reported.
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

    def discussions(self, tx: Transaction) -> list[ActivityEvent]:
        """Return events of comments and proposals since then, the oldest first, some hundred at a time."""
        newest = tx.activity.newest()
        if newest <= self.event:
            return []
        news = tx.activity.after(self.event, AT_A_TIME, kinds=("comment", "proposal"))
        self.event = news[-1].number if len(news) == AT_A_TIME else newest
        return [tell_event(event) for event in news]

    def find_changed_jobs(self, tx: Transaction) -> list[StoredJob]:
        """Return jobs whose state or progress has changed since the last report."""
        # Another server's clock may be behind, and ended jobs become visible a little later.
        time, known = now(-timedelta(seconds=CLOCKS_APART)), self.jobs
        jobs = tx.jobs.active_or_ended_since(self.time)
        seen: Told = {job.uuid: (job.state, job.stage, job.share, job.cancel) for job in jobs}
        self.jobs, self.time = seen, time
        return [job for job in jobs if known.get(job.uuid) != seen[job.uuid]]
