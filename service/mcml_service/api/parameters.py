"""Parameters that an endpoint does not know are refused: a misspelt one would be dropped in silence."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from difflib import get_close_matches
from typing import Any

from fastapi import Request, params
from fastapi.dependencies.models import Dependant
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute


async def require_known_parameters(request: Request) -> None:
    """A dependency of every endpoint: RequestValidationError for names in query or form that it does not have."""
    route: APIRoute = request.scope["route"]
    if route.endpoint not in _KNOWN:
        _KNOWN[route.endpoint] = _names(route)
    query, form = _KNOWN[route.endpoint]
    faults = [_fault("query", name, query) for name in request.query_params if name not in query]
    if form:
        # Read already, for the endpoint's own fields.
        faults += [_fault("body", name, form) for name in await request.form() if name not in form]
    if faults:
        raise RequestValidationError(faults)


_KNOWN: dict[Callable[..., Any], tuple[frozenset[str], frozenset[str]]] = {}
"""By endpoint, since routes cannot be keys: the names it knows in its query, and in its form."""


def _names(route: APIRoute) -> tuple[frozenset[str], frozenset[str]]:
    needed = list(_all(route.dependant))
    query = frozenset(field.alias for each in needed for field in each.query_params)
    body = (field for each in needed for field in each.body_params)
    return query, frozenset(field.alias for field in body if isinstance(field.field_info, params.Form))


def _all(dependant: Dependant) -> Iterator[Dependant]:
    """Yield the dependencies of an endpoint, and their dependencies."""
    yield dependant
    for each in dependant.dependencies:
        yield from _all(each)


def _fault(where: str, name: str, known: frozenset[str]) -> dict[str, object]:
    near = get_close_matches(name.lower(), sorted(known), 1, 0.6)
    others = f"Its parameters are {', '.join(sorted(known))}." if known else "It takes none here."
    hint = f"Did you mean {near[0]}?" if near else others
    return {"type": "unknown_parameter", "loc": (where, name), "msg": f"This endpoint has no such parameter. {hint}"}
