"""What a model refuses is refused in words, wherever the model is made of what was sent."""

from __future__ import annotations

from fastapi import FastAPI

from mcml_schemas.querying.queries import QueryRequest
from mcml_service.storage.database import Database
from tests.builders import one_kind, served


@one_kind
def test_no_model_of_ours_is_a_failure_of_the_server(database: Database) -> None:
    """An endpoint that makes one by itself, as those that gather a request from parameters do."""
    with served(database) as client:
        assert isinstance(client.app, FastAPI)
        client.app.add_api_route("/gathered", lambda: QueryRequest(q="", limit=0))
        answer = client.get("/gathered")
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert [fault["in"] for fault in answer.json()["errors"]] == ["q", "limit"]
