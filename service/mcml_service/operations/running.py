"""Running queries, for owners."""

from __future__ import annotations

from datetime import timedelta
from typing import Annotated

from pydantic import Field

from mcml_schemas.querying.running import RunningQueries, RunningQuery
from mcml_service.operations.call import Call
from mcml_service.storage.core.identifiers import now


def list_running_queries(call: Call) -> RunningQueries:
    """Oldest first. There are at most as many as worker processes."""
    return RunningQueries(
        items=[
            RunningQuery(
                id=query.id,
                q=query.text,
                author=query.limits.author,
                began=now(timedelta(seconds=-query.seconds)),
                seconds=round(query.seconds, 3),
            )
            for query in call.queries.running()
        ]
    )


def end_running_query(call: Call, query: Annotated[int, Field(ge=1, description="Its number", examples=[17])]) -> None:
    """The client of the query gets the error `query-cancelled`."""
    call.queries.end(query)
