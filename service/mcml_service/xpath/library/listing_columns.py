"""The list of documents as columns that are stored on disk."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from mcml_service.storage.documents.columns import Listed
from mcml_service.xpath.nodes.stored import Columns

NUMBERS = ("key", "skeleton", "frames", "revision", "project")
"""Of Listed; all else are texts."""


def columns(documents: list[Listed], commit: int) -> dict[str, Any]:
    """Documents as a commit left them, in their order."""
    by_name = dict(zip(Listed._fields, zip(*documents, strict=True), strict=True))
    found: dict[str, Any] = {"commit": commit}
    return found | {
        name: np.array(column, np.int64) if name in NUMBERS else list(column) for name, column in by_name.items()
    }


def restored(found: Columns) -> list[Listed]:
    """The documents of such columns."""
    by_name = (found[name].tolist() if name in NUMBERS else found[name] for name in Listed._fields)
    # `Listed._make` takes three times as long.
    return list(map(partial(tuple.__new__, Listed), zip(*by_name, strict=True)))
