"""Errors as problem details (RFC 9457): the whole mapping on one screen."""

from __future__ import annotations

from typing import Any

import orjson

from mcml import errors
from mcml.answers import UploadError
from mcml_schemas.problem import Problem, Where
from mcml_service.analysis.interface import AnalysisError

STATUS_OF: dict[type[errors.McmlError], int] = {
    errors.FormatError: 422,
    errors.UnsupportedError: 415,
    errors.DocumentError: 422,
    errors.ConversionError: 422,
    errors.VocabularyError: 422,
    errors.QueryError: 422,
    errors.RequestError: 422,
    errors.LimitError: 422,
    errors.SizeError: 413,
    AnalysisError: 422,
    errors.NotFoundError: 404,
    errors.ConflictError: 409,
    errors.StoreError: 500,
    errors.SpaceError: 507,
    errors.UnavailableError: 503,
    errors.BusyError: 503,
    errors.ShareError: 429,
    errors.AttemptsError: 429,
    errors.AccessError: 403,
}


class PreconditionError(errors.McmlError):
    """If-Match is missing (428) or names another revision (412)."""

    def __init__(self, what: str, status: int, remedy: str) -> None:
        super().__init__(what, remedy=remedy)
        self.status = status


def status_of(error: errors.McmlError) -> int:
    if isinstance(error, PreconditionError):
        return error.status
    return next((STATUS_OF[kind] for kind in type(error).__mro__ if kind in STATUS_OF), 500)


def problem_of(error: errors.McmlError) -> Problem:
    """Convert an error to a problem."""
    if isinstance(error, UploadError):
        first = error.problems[0].problem
        return first.model_copy(update={"problems": [item.model_dump(exclude_none=True) for item in error.problems]})
    where = None
    if error.at is not None:
        where = Where(file=error.at.file, line=error.at.line, column=error.at.column, element=error.at.element)
    facts = {name: value for name, value in error.details.items() if name != "code"}
    return Problem(
        type=f"/docs/problems#{errors.kind_name(type(error))}",
        title=errors.kind_name(type(error)).replace("-", " ").capitalize(),
        status=status_of(error),
        detail=error.what,
        where=where,
        remedy=error.remedy,
        code=error.details.get("code"),
        details=_plain(facts) if facts and "code" in error.details else None,
    )


def _plain(facts: dict[str, Any]) -> Any:
    """Facts as JSON has them: numbers of NumPy become plain ones, NaN and infinity none."""
    return orjson.loads(orjson.dumps(facts, default=str, option=orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS))
