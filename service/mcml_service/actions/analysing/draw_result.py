"""A picture of a stored result, drawn by matplotlib: SVG or PNG, for a page or a paper."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from numpy.typing import NDArray

from mcml.errors import NotFoundError, UnsupportedError
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Analysis, Part, Parts, Picture
from mcml_service.analysis.pictures import STYLE, picture_of_part
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.results import StoredPart, StoredResult

Form = Literal["svg", "png"]


class _Arrays(Mapping[str, NDArray[Any]]):
    """Arrays of a part, each read on use: a picture needs few of them."""

    def __init__(self, tx: Transaction, key: int, part: StoredPart) -> None:
        self._tx, self._key, self._part = tx, key, part
        self._read: dict[str, NDArray[Any]] = {}

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._part.arrays:
            raise KeyError(name)
        if name not in self._read:
            self._read[name] = self._tx.results.array(self._key, self._part, name)
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._part.arrays)

    def __len__(self) -> int:
        return len(self._part.arrays)


def draw_result(
    tx: Transaction, uuid: str, name: str | None, form: Form, dpi: int, inches: tuple[float | None, float | None]
) -> tuple[str, bytes]:
    """The name of a picture of a result, and its bytes.

    name: of a picture of the analysis, or of a part; None: the first picture, else the first part that can be drawn.
    inches: width and height, None as the picture is meant. Raises NotFoundError, UnsupportedError without matplotlib.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        raise UnsupportedError(
            "Pictures need matplotlib.", remedy="Install the extra `plots`: pip install 'mcml-repository[plots]'."
        ) from None
    stored = tx.results.get(uuid)
    parts = _parts(tx, stored)
    chosen, picture = _picture(ANALYSES.get(stored.analysis), parts, name)
    wanted = {part: parts[part] for part in picture.parts if part in parts}
    size = (inches[0] or picture.inches[0], inches[1] or picture.inches[1])
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        picture.draw(wanted, figure)
        file = io.BytesIO()
        # No date: the same result gives the same file.
        metadata = {"Title": stored.name, **({"Date": None} if form == "svg" else {})}
        figure.savefig(file, format=form, dpi=dpi, metadata=metadata)
    return chosen, file.getvalue()


def pictures_of(analysis: Analysis | None, parts: Mapping[str, Part]) -> dict[str, Picture]:
    """Return every picture of a result: the analysis's own, then each part, drawn by its kind."""
    own = {
        name: picture for name, picture in (analysis.pictures if analysis else {}).items() if picture.parts[0] in parts
    }
    drawn = {name: part for name, part in parts.items() if part.kind not in ("clip", "model") and name not in own}
    rank = {"curve": 0, "points": 1, "graph": 2, "table": 3}
    plain = sorted(drawn, key=lambda name: (rank[drawn[name].kind], name))
    described = analysis.parts if analysis else {}
    words = {name: described[name].description if name in described else "" for name in plain}
    return own | {name: picture_of_part(name, drawn[name], words[name]) for name in plain}


def _picture(analysis: Analysis | None, parts: Parts, name: str | None) -> tuple[str, Picture]:
    pictures = pictures_of(analysis, parts)
    if not pictures:
        raise NotFoundError("This result has nothing to draw.", remedy="Look at its parts.")
    if name is None:
        return next(iter(pictures.items()))
    if name not in pictures:
        raise NotFoundError(f"The result has no picture {name!r}.", remedy=f"It has: {', '.join(pictures)}.")
    return name, pictures[name]


def _parts(tx: Transaction, stored: StoredResult) -> Parts:
    """Return the parts of a result and, if it continues another, the parts of that one."""
    parts = {
        part.name: Part(part.kind, part.data, _Arrays(tx, stored.key, part))  # type: ignore[arg-type]  # reads arrays as a dict of them would
        for part in tx.results.parts(stored.key)
    }
    if stored.continues and stored.parent is not None:
        return {**_parts(tx, tx.results.get(stored.parent)), **parts}
    return parts
