"""The HTTP API: one file a resource. Check, call, answer."""

from __future__ import annotations

from fastapi import APIRouter

from service.api import catalogues, documents, elements, exports, frames, health, labels, page, queries

PREFIX = "/api/v1"

ROUTERS: list[tuple[APIRouter, str]] = [
    (documents.router, PREFIX),
    (exports.router, PREFIX),
    (frames.router, PREFIX),
    (labels.router, PREFIX),
    (elements.router, PREFIX),
    (queries.router, PREFIX),
    (catalogues.router, PREFIX),
    (health.router, ""),
    (page.router, ""),
]
"""Every router with its prefix."""
