"""Values by which a list of documents can be filtered, with counts."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import MOTION_NAME, PROJECT, shown

_BINS = {"edges": [0.5, 5.5, 10.5], "counts": [80, 160]}


class Count(BaseModel):
    value: str
    documents: int


class RateCount(BaseModel):
    value: float = Field(description="Frames a second, rounded")
    documents: int


class SkeletonCount(BaseModel):
    skeleton: int
    joints: int
    documents: int


class Histogram(BaseModel):
    """Bins of equal width, or of equal ratio where the greatest number is over 50 times the smallest. edges: one more
    than counts; each bin begins with its edge, the last one ends with one."""

    edges: list[float]
    counts: list[int]


class PropertyCounts(BaseModel):
    name: str
    documents: int = Field(description="That have it")
    numbers: Histogram | None = Field(None, description="Of values that are numbers")
    texts: list[Count] = Field(description="Other values")


class FacetList(BaseModel):
    """Counts of matching documents; for each facet the most frequent values."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "total": 240,
                "projects": [{"value": PROJECT, "documents": 240}],
                "formats": [{"value": "bvh", "documents": 240}],
                "skeletons": [{"skeleton": 3, "joints": 31, "documents": 240}],
                "motion_names": [{"value": MOTION_NAME, "documents": 42}],
                "lengths": _BINS,
                "rates": [{"value": 120.0, "documents": 240}],
                "unknown": 0,
                "properties": [{"name": "age", "documents": 240, "numbers": _BINS, "texts": []}],
            }
        )
    )

    total: int
    projects: list[Count]
    formats: list[Count]
    skeletons: list[SkeletonCount]
    motion_names: list[Count]
    lengths: Histogram | None = Field(None, description="Seconds")
    rates: list[RateCount]
    unknown: int = Field(description="Documents whose rate, and so whose length, is unknown")
    properties: list[PropertyCounts]
