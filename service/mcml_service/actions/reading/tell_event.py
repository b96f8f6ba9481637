"""An event of the store as answers have it."""

from __future__ import annotations

from typing import Any

from mcml_schemas.team.activity import ActivityEvent
from mcml_service.storage.projects.activity import Event


def tell_event(event: Event) -> ActivityEvent:
    facts: dict[str, Any] = dict(vars(event))
    return ActivityEvent(id=facts.pop("number"), **facts)
