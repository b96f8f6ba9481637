"""The log of a server: lines as text or JSON, each with the id of its request, and one for a fault that repeats."""

from __future__ import annotations

import json
import logging
import re
import secrets
import sys
import time
import traceback
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from mcml_service.settings import Settings

REQUEST: ContextVar[str | None] = ContextVar("request", default=None)
"""The id of the request that is worked on, in threads too."""

AGAIN_SECONDS = 60.0
"""Time in which a repeated fault is only counted."""

MANY = 500
"""Kinds of faults that are remembered."""

_ID = re.compile(r"[A-Za-z0-9._:-]{1,64}")
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")

requests = logging.getLogger("mcml.requests")


def begin_request(said: str | None) -> str:
    """Return the id of a request: the id from its client or a proxy if valid, else a new one."""
    name = said if said is not None and _ID.fullmatch(said) else secrets.token_hex(8)
    REQUEST.set(name)
    return name


def keep_log(settings: Settings) -> None:
    """Send the log of this process to standard error, as configured in the settings."""
    handler = Faults(sys.stderr)
    handler.setFormatter(Line() if settings.log_format == "text" else JsonLine())
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger("mcml").setLevel(settings.log_level.upper())


class Line(logging.Formatter):
    """Format a line: time, level, source, id of the request, and message."""

    def format(self, record: logging.LogRecord) -> str:
        told = _describe(record)
        head = f"{told['time']} {told['level']} {told['source']} {told.get('request', '-')}: {told['message']}"
        if "repeated" in told:
            head += f" (and {told['repeated']} times since the last message)"
        # Addresses may contain line breaks: they are escaped, so that nobody can forge log lines.
        head = _CONTROL.sub(lambda found: ascii(found[0])[1:-1], head)
        # Nor in the text of an exception: lines of a traceback are indented.
        traced = [_CONTROL.sub("?", line) for line in told.get("traceback", "").splitlines()]
        return "\n    ".join([head, *traced])


class JsonLine(logging.Formatter):
    """The same as an object, with the facts of a request by their names."""

    def format(self, record: logging.LogRecord) -> str:
        # In ASCII: names of files may hold bytes that are no text.
        return json.dumps(_describe(record), default=str)


def _describe(record: logging.LogRecord) -> dict[str, Any]:
    told: dict[str, Any] = {
        "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
        "level": record.levelname.lower(),
        "source": record.name,
        "message": record.getMessage().strip(),
    }
    request = REQUEST.get()
    told |= {} if request is None else {"request": request}
    told |= record.__dict__.get("facts", {})
    if record.__dict__.get("repeated"):
        told["repeated"] = record.__dict__["repeated"]
    if record.exc_info and record.exc_info[1] is not None:
        told["traceback"] = "".join(traceback.format_exception(record.exc_info[1])).rstrip()
    return told


class Faults(logging.StreamHandler[Any]):
    """Logs a fault once, then counts it for a while.

    Otherwise a full disk, or a lack of files, would fill the log. again: seconds after which it is logged again, with
    its count.
    """

    def __init__(self, stream: Any = None, again: float = AGAIN_SECONDS) -> None:
        super().__init__(stream)
        self._again = again
        self._seen: dict[tuple[Any, ...], _Fault] = {}

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno < logging.WARNING or self._is_news(record):
            super().emit(record)

    def close(self) -> None:
        """Log the counts of repeated faults."""
        self.acquire()
        try:
            self._tell_rest()
        finally:
            self.release()
        super().close()

    def _is_news(self, record: logging.LogRecord) -> bool:
        error = record.exc_info[1] if record.exc_info else None
        # uvicorn logs an error again that was logged here.
        if error is not None and vars(error).setdefault("told_by", record.name) != record.name:
            return False
        key = (record.name, record.levelno, *((record.msg,) if error is None else _place(error)))
        fault = self._seen.get(key)
        if fault is not None and time.monotonic() - fault.since < self._again:
            fault.count += 1
            return False
        if len(self._seen) >= MANY:
            self._tell_rest()
        record.repeated = 0 if fault is None else fault.count
        self._seen[key] = _Fault(record.name, record.levelno, record.getMessage(), time.monotonic())
        return True

    def _tell_rest(self) -> None:
        for fault in self._seen.values():
            if fault.count:
                facts = {"name": fault.source, "levelno": fault.level, "levelname": logging.getLevelName(fault.level)}
                super().emit(logging.makeLogRecord({**facts, "msg": fault.message, "repeated": fault.count}))
        self._seen.clear()


@dataclass
class _Fault:
    """A logged fault. since: time (seconds of the monotonic clock). count: number of repetitions."""

    source: str
    level: int
    message: str
    since: float
    count: int = 0


def _place(error: BaseException) -> tuple[Any, ...]:
    """Where an error came from: the same kind at the same line is the same fault."""
    *_, last = (None, *traceback.walk_tb(error.__traceback__))
    return (type(error), *((last[0].f_code.co_filename, last[1]) if last else ()))
