"""The HTTP API: one file a resource. Check, call, answer."""

from __future__ import annotations

from fastapi import APIRouter

from service.api import (
    analyses,
    catalogues,
    compose,
    documents,
    elements,
    exports,
    frame_edits,
    frames,
    health,
    jobs,
    labels,
    mappings,
    names,
    page,
    properties,
    queries,
    results,
    revisions,
)

PREFIX = "/api/v1"

ROUTERS: list[tuple[APIRouter, str]] = [
    (documents.router, PREFIX),
    (revisions.router, PREFIX),
    (exports.router, PREFIX),
    (frames.router, PREFIX),
    (frame_edits.router, PREFIX),
    (labels.router, PREFIX),
    (properties.router, PREFIX),
    (elements.router, PREFIX),
    (queries.router, PREFIX),
    (compose.router, PREFIX),
    (mappings.router, PREFIX),
    (names.router, PREFIX),
    (analyses.router, PREFIX),
    (jobs.router, PREFIX),
    (results.router, PREFIX),
    (catalogues.router, PREFIX),
    (health.router, ""),
    (page.router, ""),
]
"""Every router with its prefix."""
