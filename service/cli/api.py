"""The REST API as commands use it: of a server, or of the service in this process on a store of this machine."""

from __future__ import annotations

import asyncio
import queue
import secrets
import threading
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from typing import Any

import httpx

from service.errors import AccessError, McmlError, NotFoundError, Place, StoreError
from service.local_secret import PREFIX, read_secret
from service.settings import Settings, data_folder, is_loopback
from service.storage.database import Database

LOCAL = "http://127.0.0.1"


class Api:
    """Requests to `/api/v1`; problems come back as errors of ours."""

    def __init__(self, http: httpx.Client) -> None:
        self._http = http

    def send(self, method: str, path: str, accept: tuple[int, ...] = (), **request: Any) -> httpx.Response:
        """The answer, if it is a success or one of the statuses `accept`; else McmlError."""
        try:
            answer = self._http.request(method, path, **request)
        except httpx.HTTPError as error:
            raise StoreError(f"The server does not answer: {error}", remedy="Check --server.") from error
        if answer.is_success or answer.status_code in accept:
            return answer
        raise error_of(answer)

    @contextmanager
    def stream(self, method: str, path: str, **request: Any) -> Iterator[httpx.Response]:
        """An answer that is read while it comes."""
        try:
            with self._http.stream(method, path, **request) as answer:
                if answer.status_code != 200:
                    answer.read()
                    raise error_of(answer)
                yield answer
        except httpx.HTTPError as error:
            raise StoreError(f"The server does not answer: {error}", remedy="Check --server.") from error


def remote_api(address: str, token: str | None) -> Api:
    """A server's API. Without a token, a server on this machine is sent the secret that it keeps for its owner."""
    if token is None and is_loopback(httpx.URL(address).host):
        token = read_secret(data_folder())
    headers = {"authorization": f"Bearer {token}"} if token else {}
    return Api(httpx.Client(base_url=address.rstrip("/") + "/api/v1", headers=headers, timeout=600))


def local_api(database: Database, settings: Settings) -> Api:
    """The service on a store, in this process. Whoever runs the command may do what the owner of the store may."""
    # Imported late: a second, which short commands need not wait.
    from service.app import create_app

    secret = PREFIX + secrets.token_urlsafe(32)
    app = create_app(settings, database, lambda: secret)
    headers = {"authorization": f"Bearer {secret}"}
    return Api(httpx.Client(base_url=f"{LOCAL}/api/v1", headers=headers, transport=_InProcess(app)))


def error_of(answer: httpx.Response) -> McmlError:
    """A problem that the service answered, as an error."""
    try:
        body = answer.json()
    except ValueError:
        body = {"detail": f"The server answered {answer.status_code}."}
    kinds = {401: AccessError, 403: AccessError, 404: NotFoundError}
    kind = kinds.get(answer.status_code, McmlError)
    where = body.get("where")
    error = kind(body.get("detail", "refused"), at=Place(**where) if where else None, remedy=body.get("remedy"))
    if "code" in body:
        error.details |= {"code": body["code"]} | (body.get("details") or {})
    return error


class _InProcess(httpx.BaseTransport):
    """An ASGI application (asgi.readthedocs.io, HTTP 2.3) as the other end of requests; answers stream."""

    def __init__(self, app: Any) -> None:
        self._app = app

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        body = request.read()
        said: queue.SimpleQueue[MutableMapping[str, Any] | BaseException | None] = queue.SimpleQueue()

        async def receive() -> MutableMapping[str, Any]:
            nonlocal body
            if body is None:
                await asyncio.Event().wait()
            part, body = body, None  # type: ignore[assignment]
            return {"type": "http.request", "body": part}

        async def send(message: MutableMapping[str, Any]) -> None:
            said.put(message)

        def run() -> None:
            try:
                asyncio.run(self._app(_scope(request), receive, send))
                said.put(None)
            except BaseException as error:
                said.put(error)

        threading.Thread(target=run, daemon=True).start()
        return _answer(said)


def _scope(request: httpx.Request) -> dict[str, Any]:
    return {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": request.method,
        "scheme": request.url.scheme,
        "path": request.url.path,
        "raw_path": request.url.raw_path.partition(b"?")[0],
        "query_string": request.url.query,
        "root_path": "",
        "headers": [(name.lower(), value) for name, value in request.headers.raw],
        "client": ("127.0.0.1", 0),
        "server": ("127.0.0.1", 80),
        "state": {},
    }


def _answer(said: queue.SimpleQueue[MutableMapping[str, Any] | BaseException | None]) -> httpx.Response:
    start = said.get()
    if start is None or isinstance(start, BaseException):
        raise httpx.RemoteProtocolError(f"no answer: {start}")

    class Body(httpx.SyncByteStream):
        def __iter__(self) -> Iterator[bytes]:
            # What is raised behind an answer is its incident, which the service has logged.
            while not isinstance(message := said.get(), BaseException) and message is not None:
                if message["type"] == "http.response.body":
                    yield message.get("body", b"")

    return httpx.Response(start["status"], headers=start["headers"], stream=Body())
