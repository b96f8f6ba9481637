"""Help with queries: examples from the library, and ranges of quantities in it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml.errors import McmlError
from mcml_schemas.querying.examples import QuantityRange, QueryExample, QueryExamples
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.operations.arguments import InProject
from mcml_service.operations.call import Call

_SECONDS = 4.0
"""Time limit of all examples together, and of a range."""


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


def get_quantity_range(
    call: Call,
    quantity: Annotated[
        str, Field(max_length=1000, description="NAME:ARGUMENT,ARGUMENT", examples=["speed:left_hand"])
    ],
    project: InProject = None,
) -> QuantityRange:
    """Quantiles over the frames of a sample of 32 clips, for choosing a threshold. Clips without the joints or the unit
    are left out; `clips` counts the others. The search ends after 4 s, with the clips that were read.
    """
    # Imported here: other operations need no mathematics.
    from mcml.motion.bodies.quantities import asked_quantity
    from mcml_service.actions.suggesting.find_range import find_range
    from mcml_service.actions.suggesting.sample_motion import sample_motion
    from mcml_service.xpath.limits import Limits

    asked = asked_quantity(quantity)
    limits = Limits(_SECONDS, call.settings.query_elements, call.client, call.author)
    with call.database.read() as tx:
        return find_range(tx, sample_motion(tx, call.queries.caches, project, limits), asked, limits)
