"""Help with queries: examples from the library."""

from __future__ import annotations

from mcml.errors import McmlError
from mcml_schemas.querying.examples import QueryExample, QueryExamples
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.operations.arguments import InProject
from mcml_service.operations.call import Call

_SECONDS = 4.0
"""Time limit of all examples together."""


def get_query_examples(call: Call, project: InProject = None) -> QueryExamples:
    """At most eight expressions about labels, joints and activities of the library. Thresholds come from a sample of
    32 clips, in which each expression is evaluated: expressions without frames are left out. The search ends after 4 s;
    later calls for the same state of the library take the same examples.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.suggesting.find_examples import ExampleMaker, find_examples
    from mcml_service.actions.suggesting.sample_motion import sample_motion
    from mcml_service.xpath.library.listing import Scope
    from mcml_service.xpath.limits import Limits

    with call.database.read() as tx:
        key = call.view, project, tx.newest_commit()
        known = call.repository.examples.find(key)
        if known is not None:
            return known
        limits = Limits(_SECONDS, call.settings.query_elements, call.client, call.author)
        sample = sample_motion(tx, call.queries.caches, project, limits)
        counts = Scope(tx, call.queries.caches.listing, project=project).used_counts("span")
        labels = sorted(counts, key=lambda name: (-counts[name], name))

    def finds(example: QueryExample) -> bool:
        documents = sample.documents if "mo:" in example.q else []
        request = QueryRequest(q=example.q, document=documents, project=project, limit=1, **{"as": "runs"})
        try:
            return bool(call.queries.answer(request, limits).items)
        except McmlError:
            return False

    maker = ExampleMaker(sample, labels, limits)
    found = QueryExamples(items=find_examples(maker, finds), document=sample.choose_clip())
    if sample.is_whole and not limits.over:
        call.repository.examples.put(key, found)
    return found
