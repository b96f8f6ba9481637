"""Queries of a command, in its own process, within limits of the operating system."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from mcml.processes.bounds import bounded
from mcml_schemas.querying.queries import QueryAnswer, QueryRequest
from mcml_service.xpath.answer.streams import Answer, Shown
from mcml_service.xpath.language.complete import Completion
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import out_of_memory


class BoundedQueries(Queries):
    """The query engine of a short-lived process that queries from its main thread."""

    def answer(self, request: QueryRequest, limits: Limits | None = None) -> QueryAnswer:
        limits = limits or self.limits()
        with self._bounded(limits):
            return super().answer(request, limits)

    def stream(self, request: QueryRequest, limits: Limits | None = None) -> Answer | Shown:
        limits = limits or self.limits()
        with self._bounded(limits):
            return super().stream(request, limits)

    def completions(
        self, text: str, at: int, documents: Sequence[str], project: str | None
    ) -> tuple[int, list[Completion]]:
        with self._bounded(self.limits()):
            return super().completions(text, at, documents, project)

    @contextmanager
    def _bounded(self, limits: Limits) -> Iterator[None]:
        memory = self.settings.query_memory_mib << 20
        try:
            with bounded(memory, limits.overdue):
                yield
        except MemoryError:
            raise out_of_memory(memory) from None
