"""Values by which the list of documents can be filtered."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml_schemas.querying.facets import Count, FacetList, Histogram, PropertyCounts, RateCount, SkeletonCount
from mcml_service.operations.call import Call
from mcml_service.operations.documents import Wanted, has_quick_filter
from mcml_service.operations.operation import quick_if
from mcml_service.storage.lists.facets import Bins, Counts


@quick_if(has_quick_filter)
def get_facets(
    call: Call,
    wanted: Wanted,
    limit: Annotated[int, Field(ge=1, le=1000, description="Most values of each facet", examples=[50])] = 100,
    bins: Annotated[int, Field(ge=1, le=100, description="Of each range of numbers", examples=[12])] = 12,
) -> FacetList:
    """Takes the conditions of the list of documents, and counts the matching ones."""
    conditions = wanted.filter(call)
    with call.database.read() as tx:
        facets = call.repository.register.facets(tx, conditions, limit, bins)
    return FacetList(
        total=facets.total,
        projects=_counts(facets.projects),
        formats=_counts(facets.formats),
        skeletons=[
            SkeletonCount(skeleton=key, joints=joints, documents=count) for (key, joints), count in facets.skeletons
        ],
        motion_names=_counts(facets.motion_names),
        lengths=_histogram(facets.lengths),
        rates=[RateCount(value=value, documents=count) for value, count in facets.rates],
        unknown=facets.unknown,
        properties=[
            PropertyCounts(
                name=item.name, documents=item.documents, numbers=_histogram(item.bins), texts=_counts(item.texts)
            )
            for item in facets.properties
        ],
    )


def _counts(found: Counts) -> list[Count]:
    return [Count(value=value, documents=count) for value, count in found]


def _histogram(found: Bins | None) -> Histogram | None:
    return None if found is None else Histogram(edges=found.edges, counts=found.counts)
