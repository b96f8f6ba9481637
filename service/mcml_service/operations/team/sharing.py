"""Share links, which show some documents to people without an account."""

from __future__ import annotations

from datetime import timedelta
from typing import Annotated, Any

from pydantic import Field

from mcml.files.targets import find_target
from mcml_schemas.team.shares import SharedRevision, ShareList, ShareMade, ShareRequest, ShareView
from mcml_service.operations.arguments import MOST, InProject
from mcml_service.operations.call import Call
from mcml_service.storage.team.shares import Share

Number = Annotated[int, Field(ge=1, le=MOST, description="Number of the link", examples=[2])]


def list_shares(call: Call, project: InProject = None) -> ShareList:
    """Lists valid links to projects that you can edit."""
    with call.database.read() as tx:
        shares = tx.shares.all(None if project is None else tx.projects.get(project))
    return ShareList(items=[ShareView(**_describe(link)) for link in shares])


def add_share(call: Call, request: ShareRequest) -> ShareMade:
    """Visitors with the link can play these documents, read their frames, and export them in the allowed formats.

    They cannot see lists, history or uploaded files, or run queries. The link is shown only once.
    """
    for name in request.formats:
        find_target(name)
    lasts = timedelta(days=request.days)
    with call.database.write(call.author) as tx:
        secret, made = tx.shares.add(
            request.name, request.documents, request.formats, call.author, lasts, latest=request.latest
        )
    return ShareMade(**_describe(made), path=f"/shared#{secret}")


def revoke_share(call: Call, number: Number) -> None:
    """Visitors with the link lose access at once."""
    with call.database.write(call.author) as tx:
        tx.shares.remove(number)


def _describe(share: Share) -> dict[str, Any]:
    documents = [
        SharedRevision(id=uuid, revision=shared.revision, latest=shared.latest)
        for uuid, shared in share.documents.items()
    ]
    return {**vars(share), "documents": documents, "formats": sorted(share.formats)}
