"""A transaction on the store, with all repositories: `tx.documents`, `tx.tracks`, ….

The only place that creates them. A repository gets its transaction, and names in its constructor the other repositories
that it needs.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

from sqlalchemy import Table

from mcml.errors import DamageError
from mcml_service.storage.core.transaction import COMMAND_LINE, LATEST, BaseTransaction
from mcml_service.storage.documents.bodies import Bodies
from mcml_service.storage.documents.columns import Columns
from mcml_service.storage.documents.damage import describe_damage
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.documents.heads import Heads
from mcml_service.storage.documents.media import MediaOfDocuments
from mcml_service.storage.documents.spans import Spans
from mcml_service.storage.documents.thumbnails import Thumbnails
from mcml_service.storage.documents.tracks import Tracks
from mcml_service.storage.documents.uploads import Uploads
from mcml_service.storage.history.pruning import Pruning
from mcml_service.storage.history.purging import Purging
from mcml_service.storage.history.revisions import Revisions
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.projects import Projects
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.team.accounts import Accounts
from mcml_service.storage.team.attempts import Attempts
from mcml_service.storage.team.comments import Comments
from mcml_service.storage.team.idempotency import Requests
from mcml_service.storage.team.members import Members
from mcml_service.storage.team.presence import Presence
from mcml_service.storage.team.proposals import Proposals
from mcml_service.storage.team.sessions import Sessions
from mcml_service.storage.team.shares import Shares
from mcml_service.storage.team.tokens import Tokens
from mcml_service.storage.team.webhooks import Webhooks
from mcml_service.storage.work.aliases import Aliases
from mcml_service.storage.work.jobs import Jobs
from mcml_service.storage.work.mappings import Mappings
from mcml_service.storage.work.results import Results
from mcml_service.storage.work.saved import Saved

__all__ = ["COMMAND_LINE", "LATEST", "Transaction"]


class Transaction(BaseTransaction):
    """See `BaseTransaction`. Repositories are created on first use."""

    def damage(self, table: Table, row: tuple[Any, ...]) -> DamageError:
        return describe_damage(self, table, row)

    @cached_property
    def documents(self) -> Documents:
        return Documents(self, self.activity, self.quotas)

    @cached_property
    def revisions(self) -> Revisions:
        return Revisions(self)

    @cached_property
    def heads(self) -> Heads:
        return Heads(self)

    @cached_property
    def tracks(self) -> Tracks:
        return Tracks(self)

    @cached_property
    def columns(self) -> Columns:
        return Columns(self)

    @cached_property
    def spans(self) -> Spans:
        return Spans(self)

    @cached_property
    def thumbnails(self) -> Thumbnails:
        return Thumbnails(self)

    @cached_property
    def bodies(self) -> Bodies:
        return Bodies(self)

    @cached_property
    def uploads(self) -> Uploads:
        return Uploads(self)

    @cached_property
    def projects(self) -> Projects:
        return Projects(self, self.quotas)

    @cached_property
    def quotas(self) -> Quotas:
        return Quotas(self)

    @cached_property
    def jobs(self) -> Jobs:
        return Jobs(self, self.activity, self.quotas)

    @cached_property
    def results(self) -> Results:
        return Results(self, self.quotas)

    @cached_property
    def aliases(self) -> Aliases:
        return Aliases(self, self.projects, self.quotas)

    @cached_property
    def pruning(self) -> Pruning:
        return Pruning(self, self.bodies, self.thumbnails, self.uploads)

    @cached_property
    def purging(self) -> Purging:
        return Purging(self, self.activity, self.documents, self.pruning, self.results, self.uploads)

    @cached_property
    def mappings(self) -> Mappings:
        return Mappings(self, self.projects, self.quotas)

    @cached_property
    def media(self) -> MediaOfDocuments:
        return MediaOfDocuments(self, self.documents, self.uploads)

    @cached_property
    def comments(self) -> Comments:
        return Comments(self, self.activity, self.members, self.quotas)

    @cached_property
    def proposals(self) -> Proposals:
        return Proposals(self, self.activity, self.documents, self.quotas)

    @cached_property
    def presence(self) -> Presence:
        return Presence(self, self.accounts)

    @cached_property
    def activity(self) -> Activity:
        return Activity(self)

    @cached_property
    def webhooks(self) -> Webhooks:
        return Webhooks(self, self.activity, self.projects, self.quotas)

    @cached_property
    def saved(self) -> Saved:
        return Saved(self, self.documents, self.projects, self.quotas)

    @cached_property
    def accounts(self) -> Accounts:
        return Accounts(self, self.activity, self.projects)

    @cached_property
    def members(self) -> Members:
        return Members(self, self.accounts, self.activity, self.quotas)

    @cached_property
    def tokens(self) -> Tokens:
        return Tokens(self, self.activity)

    @cached_property
    def shares(self) -> Shares:
        return Shares(self, self.activity, self.documents, self.projects, self.quotas)

    @cached_property
    def sessions(self) -> Sessions:
        return Sessions(self, self.shares)

    @cached_property
    def attempts(self) -> Attempts:
        return Attempts(self)

    @cached_property
    def requests(self) -> Requests:
        return Requests(self)
