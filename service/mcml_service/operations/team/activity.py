"""The activity log of the repository."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml_schemas.examples import DOCUMENT
from mcml_schemas.team.activity import ActivityKind, ActivityPage
from mcml_service.actions.reading.tell_event import tell_event
from mcml_service.operations.arguments import InProject, Page
from mcml_service.operations.call import Call
from mcml_service.storage.projects.activity import EventFilter


def list_activity(
    call: Call,
    page: Page,
    project: InProject = None,
    document: Annotated[str | None, Field(description="Only about this document", examples=[DOCUMENT])] = None,
    author: Annotated[
        str | None, Field(max_length=256, description="Only events by this person", examples=["kim"])
    ] = None,
    kind: Annotated[ActivityKind | None, Field(description="Only of this kind", examples=["comment"])] = None,
    since: Annotated[
        str | None,
        Field(
            pattern=r"^\d{4}-\d\d-\d\d(T\d\d:\d\d(:\d\d(\.\d{1,6})?)?Z)?$",
            description="Only events at or after this time, in UTC",
            examples=["2026-01-31"],
        ),
    ] = None,
) -> ActivityPage:
    """Lists events in projects that you can see.

    Events of accounts and tokens are visible to owners of the repository. The server's settings limit the days for
    which events are kept.
    """
    before = page.after(int)
    wanted = EventFilter(project, document, author, kind, since)
    with call.database.read() as tx:
        events = tx.activity.page(wanted, None if before is None else before[0], page.most(call) + 1)
    shown, more = page.cut(call, events, lambda event: (event.number,))
    return ActivityPage(items=[tell_event(event) for event in shown], next_cursor=more)
