"""One call of an operation: its repository, the user, and metadata of the answer."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from mcml_service.settings import Settings
from mcml_service.storage.core.views import WHOLE, View
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

if TYPE_CHECKING:
    from mcml_schemas.querying.examples import QueryExamples
    from mcml_service.actions.analysing.use_result import Results
    from mcml_service.actions.exporting.wear_character import MovedClips
    from mcml_service.actions.importing.encode_clip import Progress
    from mcml_service.actions.importing.import_pool import ImportPool
    from mcml_service.listing.register import Register
    from mcml_service.storage.team.shares import Share
    from mcml_service.xpath.library.cache import Cache
    from mcml_service.xpath.limits import Limits
    from mcml_service.xpath.queries import Queries

MOST_EXAMPLES = 64
"""Views, projects and states of the library whose example queries are kept."""


class Repository:
    """A store and its services, for the lifetime of the process. Services that no call needs are never imported."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings
        self.wake: Callable[[], None] = lambda: None
        """Notifies the runner of a new job."""
        self.runner: str | None = None
        """The only runner allowed to run new jobs; None: any server of the store."""
        self.import_pool: ImportPool | None = None
        """Processes that read uploads of many files, of a server."""
        self.evaluated: Literal["here", "bounded", "apart"] = "here"
        """Where queries run: in this process, with limits checked by code; in this process, with system limits, for
        a command; in separate processes, for a server.
        """

    @cached_property
    def queries(self) -> Queries:
        if self.evaluated == "apart":
            from mcml_service.xpath.query_pool import PooledQueries

            return PooledQueries(self.database, self.settings)
        if self.evaluated == "bounded":
            from mcml_service.xpath.bounded_queries import BoundedQueries

            return BoundedQueries(self.database, self.settings)
        from mcml_service.xpath.queries import Queries

        return Queries(self.database, self.settings)

    @cached_property
    def register(self) -> Register:
        """The register of documents, from which lists are read."""
        from mcml_service.listing.register import Register

        return Register()

    @cached_property
    def examples(self) -> Cache[Hashable, QueryExamples]:
        """Example queries by view, project and commit."""
        from mcml_service.xpath.library.cache import Cache

        return Cache(MOST_EXAMPLES, lambda _: 1)

    @cached_property
    def clips_on_characters(self) -> MovedClips:
        """Documents on the rigs of characters."""
        from mcml_service.actions.exporting.wear_character import MovedClips

        return MovedClips()

    @cached_property
    def results(self) -> Results:
        from mcml_service.actions.analysing.use_result import Results

        return Results(self.database, self.settings)

    def begin(self) -> None:
        """Start the processes that evaluate queries before the first query."""
        from mcml_service.xpath.query_pool import PooledQueries

        if isinstance(self.queries, PooledQueries):
            self.queries.begin()

    def close(self) -> None:
        """End the processes that evaluate queries and read imports; the store is its owner's."""
        if self.import_pool is not None:
            self.import_pool.close()
        if "queries" in self.__dict__:
            self.queries.close()


class SameError(Exception):
    """Signals that the client already has this representation."""

    def __init__(self, tag: str) -> None:
        super().__init__(tag)
        self.tag = tag


@dataclass
class Call:
    """One call of an operation.

    repository: the repository. author: name of the user. view: the visible documents and the rights of the user.
    account: its name, None without an account. share: the share link of a visitor. client: key of the user in fair
    queues. from_replica: whether the store's replica may answer. origin: address of the client, None for a process that
    opens the store itself. known: version of the answer that the client has, None if it has none. media_type: of the
    request body, if stated. progress: is called with the progress of work on files. tag: version of the answer (an
    entity tag without its quotes), set by the operation. created: path of the created resource, below /api/v1. lasting:
    the answer never changes, so it can be cached. made: whether anything was created, for operations that may only
    read.
    """

    repository: Repository
    author: str = "local"
    view: View = WHOLE
    account: str | None = None
    share: Share | None = None
    client: str = ""
    from_replica: bool = False
    origin: str | None = None
    known: Callable[[str], str | None] = lambda tag: None
    media_type: str = ""
    progress: Progress | None = None
    tag: str | None = None
    lasting: bool = False
    created: str | None = None
    made: bool = True
    held: ExitStack = field(default_factory=ExitStack)

    @cached_property
    def database(self) -> Database:
        """The store as the user may see it."""
        return self.repository.database.for_call(self.view, self.origin, from_replica=self.from_replica)

    def begin_again(self) -> None:
        """Reset the metadata of the answer, before the operation runs again on the primary store."""
        self.from_replica, self.held = False, ExitStack()
        self.tag, self.lasting, self.created, self.made = None, False, None, True
        for name in ("database", "queries"):
            self.__dict__.pop(name, None)

    @property
    def settings(self) -> Settings:
        return self.repository.settings

    @cached_property
    def queries(self) -> Queries:
        return self.repository.queries.on(self.database)

    @property
    def results(self) -> Results:
        return self.repository.results.on(self.database)

    @property
    def scope(self) -> str:
        """The highest scope of the user in any project (`operation.RIGHTS`)."""
        return self.view.most

    @cached_property
    def limits(self) -> Limits:
        """Limits of time and memory for a query of this call; a disconnected client cancels it."""
        return self.queries.limits(self.client, self.author)

    def renew_limits(self) -> None:
        """Let the time of the query begin again."""
        self.__dict__.pop("limits", None)

    def makes(self, document: str | None) -> None:
        """Set the id of the new document, or None for a preview."""
        self.made = document is not None
        self.created = None if document is None else f"documents/{document}"

    def read(self) -> Transaction:
        """A read transaction that lives until the answer is sent, for answers that are made while they are sent."""
        return self.held.enter_context(self.database.read())

    def set_tag(self, tag: str, *, lasting: bool = False) -> None:
        """Set the version of the answer.

        Raises SameError if the client already has it. lasting: the request names the revision, so the answer never
        changes.
        """
        self.tag, self.lasting = tag, lasting
        known = self.known(tag)
        if known is not None:
            raise SameError(known)
