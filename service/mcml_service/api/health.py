"""Is the service alive, is it ready, how much does it do."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import PlainTextResponse

from mcml.errors import AccessError
from mcml_schemas.catalogues import Health
from mcml_service.api.routes import call_of
from mcml_service.clips.bodies import MADE
from mcml_service.storage.core.replica import Replica
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter

router = APIRouter(tags=["health"])

_METRICS: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/plain": {"example": 'mcml_requests_total{method="GET",status="200"} 10\n'}}}
}


@router.get("/healthz", operation_id="healthz")
def healthz() -> Health:
    """The process answers."""
    return Health(status="ok")


@router.get("/readyz", operation_id="readyz", responses={503: {"model": Health, "description": "Not ready"}})
def readyz(request: Request, response: Response) -> Health:
    """The store answers and has this program's schema."""
    database = _database(request)
    version, wanted = database.schema_versions()
    if version != wanted:
        response.status_code = 503
        return Health(status=f"schema {version} is not {wanted}", database=database.name)
    return Health(status="ok", database=database.name)


@router.get("/metrics", operation_id="metrics", response_class=PlainTextResponse, responses=_METRICS)
def metrics(request: Request) -> str:
    """Counters in the Prometheus text format. Needs access to the whole store."""
    call = call_of(request)
    if not call.view.is_whole:
        raise AccessError(
            f"/metrics counts the whole store, and {call.author} sees single projects.",
            remedy="Ask an owner of the repository for a token of scope read that is limited to no project.",
        )
    counts: dict[tuple[str, int], int] = request.app.state.requests
    lines = ["# HELP mcml_requests_total Requests answered.", "# TYPE mcml_requests_total counter"]
    lines += [
        f'mcml_requests_total{{method="{method}",status="{status}"}} {count}'
        for (method, status), count in sorted(counts.items())
    ]
    with _database(request).read() as tx:
        count, missing = tx.documents.count(DocumentFilter()), len(tx.bodies.without(MADE))
    lines += ["# HELP mcml_documents Documents, by whether their body is kept.", "# TYPE mcml_documents gauge"]
    lines += [f'mcml_documents{{body="kept"}} {count - missing}', f'mcml_documents{{body="missing"}} {missing}']
    sizes = _database(request).size()
    lines += ["# HELP mcml_store_bytes Size of the store.", "# TYPE mcml_store_bytes gauge"]
    lines += [f'mcml_store_bytes{{part="{part}"}} {size}' for part, size in sorted(sizes.items())]
    replica = _database(request).replica
    if replica is not None:
        lines += _replica_lines(replica)
    return "\n".join(lines) + "\n"


def _replica_lines(replica: Replica) -> list[str]:
    behind = replica.behind()
    lines = ["# HELP mcml_replica_up Whether the replica is reachable.", "# TYPE mcml_replica_up gauge"]
    lines.append(f"mcml_replica_up {int(behind is not None)}")
    if behind is not None:
        lines += ["# HELP mcml_replica_behind_bytes Bytes of the log that it lacks."]
        lines += ["# TYPE mcml_replica_behind_bytes gauge", f"mcml_replica_behind_bytes {behind}"]
    lines += ["# HELP mcml_replica_reads_total Reads that the replica can serve, by the database that served them."]
    lines += ["# TYPE mcml_replica_reads_total counter"]
    return lines + [f'mcml_replica_reads_total{{by="{by}"}} {count}' for by, count in sorted(replica.reads.items())]


def _database(request: Request) -> Database:
    database: Database = request.app.state.repository.database
    return database
