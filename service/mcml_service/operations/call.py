"""One call of an operation: the repository it works on, who asks, and what is said of the answer beside itself."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from mcml_service.settings import Settings
from mcml_service.storage.core.views import WHOLE, View
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

if TYPE_CHECKING:
    from mcml_service.actions.analysing.use_result import Results
    from mcml_service.actions.importing.encode_clip import Progress
    from mcml_service.actions.importing.import_pool import ImportPool
    from mcml_service.listing.register import Register
    from mcml_service.storage.team.shares import Share
    from mcml_service.xpath.limits import Limits
    from mcml_service.xpath.queries import Queries


class Repository:
    """A store and what works on it for as long as the process runs. What a call does not need is never imported."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self.database = database
        self.settings = settings
        self.wake: Callable[[], None] = lambda: None
        """Tells whoever runs jobs that there is one."""
        self.runner: str | None = None
        """Who alone may run the jobs that are started; None: any server of the store."""
        self.import_pool: ImportPool | None = None
        """Processes that read uploads of many files, of a server."""
        self.evaluated: Literal["here", "bounded", "apart"] = "here"
        """Where questions are: in this process, with the limits that its code asks; the same for a command, with limits
        that the system sets; for a server in processes of their own."""

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
        """What lists are read from."""
        from mcml_service.listing.register import Register

        return Register()

    @cached_property
    def results(self) -> Results:
        from mcml_service.actions.analysing.use_result import Results

        return Results(self.database, self.settings)

    def begin(self) -> None:
        """Start what evaluates the questions of others before the first one comes."""
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
    """A signal: whoever asked has this representation already."""

    def __init__(self, tag: str) -> None:
        super().__init__(tag)
        self.tag = tag


@dataclass
class Call:
    """repository: what is worked on. author: who asks. view: what of it they see, and may do there. account: its name,
    None for who has none. share: the link that they came by. client: those who share a turn in fair queues.
    from_replica: the store's replica may answer. origin: from where they come, None for who opens the store itself.

    known: how whoever asks names this version of the answer, None where they do not have it.

    media_type: of the body that was sent, where one says it. progress: is told how far work on files is.
    tag: version of the answer (an entity tag without its quotes), set by the operation. created: address of what was
    made, below /api/v1. lasting: the answer never changes, so it need not be asked again. made: whether anything was,
    for operations that can also only look.
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
        """The store as whoever asks sees it."""
        return self.repository.database.for_call(self.view, self.origin, from_replica=self.from_replica)

    def begin_again(self) -> None:
        """Forget what was said of the answer: it is asked for anew, of the store itself."""
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
        """What they may do where they may do most (`operation.RIGHTS`)."""
        return self.view.most

    @cached_property
    def limits(self) -> Limits:
        """Time and memory of a query of this call; who leaves cancels it."""
        return self.queries.limits(self.client, self.author)

    def makes(self, document: str | None) -> None:
        """Say which document was made, or None where it was only said what would be."""
        self.made = document is not None
        self.created = None if document is None else f"documents/{document}"

    def read(self) -> Transaction:
        """A read transaction that lives until the answer is sent, for answers that are made while they are sent."""
        return self.held.enter_context(self.database.read())

    def set_tag(self, tag: str, *, lasting: bool = False) -> None:
        """Say the version of the answer. SameError where whoever asks has it.

        lasting: it is of a revision that the question names, so it will never be another.
        """
        self.tag, self.lasting = tag, lasting
        known = self.known(tag)
        if known is not None:
            raise SameError(known)
