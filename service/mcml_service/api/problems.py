"""Every error leaves as a problem document (RFC 9457)."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.encoders import jsonable_encoder
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from pydantic import ValidationError
from starlette.exceptions import HTTPException
from starlette.routing import Match

from mcml import errors
from mcml_schemas.problem import Problem
from mcml_service.actions.checking.describe_problem import problem_of
from mcml_service.api.logs import REQUEST

RETRY_SECONDS = "5"
"""Seconds after which to retry an unreachable store or a busy server."""

log = logging.getLogger("mcml.api")


def respond(problem: Problem, headers: dict[str, str] | None = None) -> JSONResponse:
    problem.request = REQUEST.get()
    return JSONResponse(
        problem.model_dump(exclude_none=True), problem.status, headers, media_type="application/problem+json"
    )


def answer(error: errors.McmlError) -> JSONResponse:
    """Return the answer for an error of this program."""
    if isinstance(error, errors.AttemptsError):
        return respond(problem_of(error), {"retry-after": str(error.seconds)})
    later = isinstance(error, (errors.UnavailableError, errors.BusyError))
    return respond(problem_of(error), {"retry-after": RETRY_SECONDS} if later else None)


def plain(
    status: int, detail: str, remedy: str | None = None, headers: Mapping[str, str] | None = None
) -> JSONResponse:
    """Return the answer for another problem, such as an unknown route."""
    title = HTTPStatus(status).phrase
    problem = Problem(type="about:blank", title=title, status=status, detail=detail, remedy=remedy)
    return respond(problem, None if headers is None else dict(headers))


def _list_methods(app: FastAPI, request: Request) -> list[str]:
    """Every method that the address of a request has; Starlette names those of the first endpoint alone."""
    asked = [
        method
        for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
        if any(route.matches({**request.scope, "method": method})[0] is Match.FULL for route in app.router.routes)
    ]
    return ["GET", "HEAD", *asked[1:]] if "GET" in asked else asked


def _words(said: str) -> str:
    """Return Pydantic's message, without its references to Python."""
    return "A file is needed here, not a text." if "UploadFile" in said else said.removeprefix("Value error, ")


def install(app: FastAPI, unknown: Callable[[Request], Response | None]) -> None:
    """Answer every error as a problem.

    unknown: returns the page for an unknown address, None if the request is not for a page.
    """

    @app.exception_handler(errors.McmlError)
    def _ours(_request: Request, error: errors.McmlError) -> JSONResponse:
        return answer(error)

    @app.exception_handler(ValidationError)
    @app.exception_handler(RequestValidationError)
    def _invalid(_request: Request, error: RequestValidationError | ValidationError) -> JSONResponse:
        # A ValidationError comes from a model that an endpoint makes from its input.
        faults: list[dict[str, Any]] = [
            {"in": ".".join(str(part) for part in fault["loc"]), "what": _words(fault["msg"])}
            for fault in error.errors()
        ]
        first = faults[0] if faults else {"in": "request", "what": "invalid"}
        problem = Problem(
            type="/docs/problems#invalid-request",
            title="Invalid request",
            status=422,
            detail=f"{first['in']}: {first['what']}",
            remedy="See the parameters of this endpoint in /docs.",
            errors=jsonable_encoder(faults),
        )
        return respond(problem)

    @app.exception_handler(HTTPException)
    def _http(request: Request, error: HTTPException) -> Response:
        shown = unknown(request) if error.status_code == 404 else None
        if shown is not None:
            return shown
        if isinstance(error.__cause__, OSError) and errors.is_full(error.__cause__):
            # FastAPI answers 400 for every error while it stores the parts of an upload.
            return respond(problem_of(errors.SpaceError()))
        if error.status_code == 400 and error.__cause__ is not None:
            # FastAPI names no reason where a body cannot even be decoded.
            return plain(
                400, "The request body does not match its content type.", "Send JSON in UTF-8, or a form as it is."
            )
        if error.status_code == 405:
            allowed = ", ".join(_list_methods(app, request))
            detail = f"{request.method} is not allowed here."
            return plain(405, detail, f"Use {allowed}.", {"allow": allowed})
        return plain(error.status_code, str(error.detail), headers=error.headers)

    @app.exception_handler(OSError)
    def _of_the_system(request: Request, error: OSError) -> JSONResponse:
        # Uploads wait in temporary files, so a disk can be full before the store is used.
        return respond(problem_of(errors.SpaceError())) if errors.is_full(error) else _answer_unexpected(request, error)

    @app.exception_handler(Exception)
    def _answer_unexpected(request: Request, error: Exception) -> JSONResponse:
        log.error("%s %s failed", request.method, request.url.path, exc_info=error)
        name = REQUEST.get() or ""
        detail = f"The server failed on this request. The log has the details under {name}."
        return plain(500, detail, "Try again; if it fails again, report that name.", {"x-request-id": name})
