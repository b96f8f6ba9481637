"""Operations of a server, through its REST API."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any
from urllib.parse import quote, unquote

import httpx
from pydantic import TypeAdapter

from mcml.answers import Content, UploadError
from mcml.client.catalogue import Operation, find_operation
from mcml.client.client import Client, FileProgress, JobProgress, follow
from mcml.errors import AccessError, McmlError, NotFoundError, Notice, Place, RequestError, StoreError, kind_of
from mcml_schemas.documents import FileProblem
from mcml_schemas.jobs import Job

NPY = b"\x93NUMPY"
"""How the file begins that numpy.save writes."""

_ANY: TypeAdapter[Any] = TypeAdapter(Any)

TIMEOUT = 600.0
"""Seconds that a server may be silent."""

BUSY = 300.0
"""Seconds for which requests to a busy server are repeated."""


class Remote(Client):
    """address: such as http://127.0.0.1:8000. token: where the server needs one. http: another way to the API."""

    def __init__(self, address: str, token: str | None = None, http: httpx.Client | None = None) -> None:
        headers = {"authorization": f"Bearer {token}"} if token else {}
        base = address.rstrip("/") + "/api/v1"
        self._http = http or httpx.Client(base_url=base, headers=headers, timeout=TIMEOUT)

    def call(self, name: str, /, *, progress: FileProgress | None = None, **given: Any) -> Any:
        operation = find_operation(name)
        given = {key: value for key, value in given.items() if value is not None}
        operation.check_names(given)
        request = self._http.build_request(operation.method, **_parts(operation, given))
        with ExitStack() as stack:
            try:
                answer = self._send(request)
                stack.callback(answer.close)
                if answer.is_success and operation.is_content and not _is_json(answer, operation):
                    return _content(answer, stack.pop_all())
                answer.read()
            except httpx.HTTPError as error:
                raise _away(error) from error
        if not answer.is_success:
            raise error_of(answer)
        model = operation.model
        return None if model is None or answer.status_code == 204 else model.model_validate_json(answer.content)

    def _send(self, request: httpx.Request) -> httpx.Response:
        """The answer to a request, which waits where the server is too busy to have begun with it."""
        end = time.monotonic() + BUSY
        while True:
            answer = self._http.send(request, stream=True)
            if answer.status_code not in (429, 503):
                return answer
            answer.read()
            seconds = answer.headers.get("retry-after", "")
            if not _is_busy(answer) or not seconds.isdigit() or time.monotonic() + int(seconds) > end:
                return answer
            answer.close()
            time.sleep(int(seconds))

    def finish(self, job: Job, progress: JobProgress) -> Job:
        return follow(self, job, progress)

    def close(self) -> None:
        self._http.close()


def _is_json(answer: httpx.Response, operation: Operation) -> bool:
    return bool(operation.answer) and answer.headers.get("content-type", "").startswith("application/json")


def _is_busy(answer: httpx.Response) -> bool:
    """Tell whether the server did nothing of a request and it can be repeated.

    An unreachable store, for example, is reported at once.
    """
    return b"#busy-error" in answer.content or b"#share-error" in answer.content


def _away(error: httpx.HTTPError) -> StoreError:
    return StoreError(f"The server is unreachable: {error}", remedy="Check its address.")


def _parts(operation: Operation, given: dict[str, Any]) -> dict[str, Any]:
    """A request as httpx takes it: address, query, headers, body."""
    path = operation.path.replace(":path}", "}")
    query: dict[str, Any] = {}
    form: dict[str, Any] = {}
    parts: dict[str, Any] = {"headers": {}}
    for name, value in given.items():
        argument = operation.arguments[name]
        if argument.place == "file":
            files = value if isinstance(value, list) else [value]
            parts["files"] = [(argument.wire, (file.name, file.stream)) for file in files]
            continue
        if argument.place == "content":
            parts["content"] = value
            parts["headers"]["content-type"] = argument.types[-1 if value.startswith(NPY) else 0]
            continue
        plain = _ANY.dump_python(value, mode="json", by_alias=True, exclude_unset=True)
        if argument.place == "path":
            # Names may hold what means something in an address, such as ? and /.
            path = path.replace(f"{{{argument.wire}}}", quote(str(plain), safe=""))
        elif argument.place == "body":
            parts["json"] = plain
        elif argument.place == "header":
            parts["headers"][argument.wire] = plain
        elif argument.place == "form":
            form[argument.wire] = _text(plain)
        else:
            query[argument.wire] = plain
    return parts | {"url": path, "params": query} | ({"data": form} if form else {})


def _text(value: Any) -> Any:
    """A value as a field of a form carries it."""
    if isinstance(value, bool):
        return str(value).lower()
    return [str(item) for item in value] if isinstance(value, list) else str(value)


def _content(answer: httpx.Response, stack: ExitStack) -> Content:
    headers = answer.headers
    name = unquote(headers.get("content-disposition", "").rpartition("UTF-8''")[2])
    prefix = "x-mcml-"
    facts = {
        key.removeprefix(prefix): text.encode("latin-1", "replace").decode("utf-8", "replace")
        for key, text in headers.items()
        if key.startswith(prefix)
    }
    notices = [Notice("warning", text) for text in facts.pop("notices", "").split(" | ") if text]

    def blocks() -> Iterator[bytes]:
        with stack:
            try:
                yield from answer.iter_bytes(1 << 20)
            except httpx.HTTPError as error:
                raise _away(error) from error

    return Content(blocks(), headers.get("content-type", ""), name or None, facts=facts, notices=notices)


def host_of(address: str) -> str:
    """The name of the host in an address."""
    return httpx.URL(address).host


def error_of(answer: httpx.Response) -> McmlError:
    """A problem that a server answered, as an error."""
    try:
        body = answer.json()
    except ValueError:
        body = {"detail": f"The server answered {answer.status_code}."}
    if "problems" in body:
        return UploadError([FileProblem(**item) for item in body["problems"]])
    kinds = {401: AccessError, 403: AccessError, 404: NotFoundError, 422: RequestError}
    kind = kind_of(body.get("type", "").rpartition("#")[2]) or kinds.get(answer.status_code, McmlError)
    where = body.get("where")
    # Kinds of errors have different constructors; an error from a server is restored without them.
    error = kind.__new__(kind)
    McmlError.__init__(
        error, body.get("detail", "refused"), at=Place(**where) if where else None, remedy=body.get("remedy")
    )
    if "code" in body:
        error.details |= {"code": body["code"]} | (body.get("details") or {})
    return error
