"""Measure quantities in frame ranges of many clips, a clip at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mcml.errors import DocumentError, FormatError, LimitError, NotFoundError, SizeError
from mcml.language.elements import to_head
from mcml.motion.bodies.quantities import AskedQuantity, asked_quantity
from mcml.numerics.curves import Array, CurveSums, Figures, normalise_range, summarise_samples
from mcml.numerics.outliers import THRESHOLD, score_outliers
from mcml_schemas.measure import MeasureRequest
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.measuring.choose_ranges import (
    ChosenClip,
    Range,
    ranges_of_labels,
    ranges_of_strides,
    require_rows,
)
from mcml_service.actions.measuring.left_out import LeftOut, find_guesses, find_reason
from mcml_service.actions.reading.read_gait import sides_of
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import Body
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_GROUPS = 5000
FIGURES = ("minimum", "maximum", "mean", "range")
"""Figures by which ranges are compared within their group."""
_PROPERTY = "property:"
_LACKS = (DocumentError, FormatError, LimitError, NotFoundError)
"""Errors of one clip, which leave it or one of its quantities out."""


@dataclass(frozen=True, eq=False)
class ClipFacts:
    """frame_time: seconds; None where unknown. properties: of the header."""

    document: str
    name: str
    project: str
    revision: int
    frame_time: float | None
    properties: Mapping[str, str]


@dataclass(eq=False)
class RangeFigures:
    """A quantity in a range. curve: (101,), None unless it was requested. score: NaN until the group is complete."""

    clip: ClipFacts
    group: RangeGroup
    range: Range
    figures: Figures
    curve: Array | None
    score: float = float("nan")
    score_of: str = ""

    @property
    def is_outlier(self) -> bool:
        return self.score > THRESHOLD


@dataclass(eq=False)
class RangeGroup:
    """Ranges of one quantity with the same values of the keys of `by`."""

    quantity: AskedQuantity
    unit: str
    values: Mapping[str, str]
    rows: list[RangeFigures] = field(default_factory=list)
    curves: CurveSums = field(default_factory=CurveSums)


@dataclass(frozen=True, eq=False)
class Measured:
    """rows: outliers first, by falling score; then in the order of clips, quantities and frames."""

    rows: Sequence[RangeFigures]
    groups: Sequence[RangeGroup]
    documents: int
    by: Sequence[str]
    warnings: list[str]


def measure_clips(
    tx: Transaction,
    read_body: Callable[[Transaction, StoredDocument], Body],
    clips: Sequence[ChosenClip],
    request: MeasureRequest,
    check: Callable[[], None],
    *,
    with_curves: bool,
) -> Measured:
    """Measure the quantities of a request in all ranges of the clips.

    read_body: returns the body of a document. check: is called between clips, and raises once the time is up. Clips
    and quantities without values have a warning. Raises RequestError or VocabularyError for an unknown quantity,
    SizeError for too many ranges or groups.
    """
    measuring = _Measuring(tx, read_body, request, with_curves)
    for clip in clips:
        check()
        measuring.measure(clip)
    return measuring.finish(len(clips))


class _Measuring:
    def __init__(
        self,
        tx: Transaction,
        read_body: Callable[[Transaction, StoredDocument], Body],
        request: MeasureRequest,
        with_curves: bool,
    ) -> None:
        self._tx, self._read_body, self._request = tx, read_body, request
        self._with_curves = with_curves
        self._asked = [asked_quantity(text) for text in dict.fromkeys(request.quantities)]
        self._units: dict[str, str] = {}
        self._groups: dict[tuple[str, ...], RangeGroup] = {}
        self._rows: list[RangeFigures] = []
        self._left_out = LeftOut()
        self._guessed = LeftOut()

    def measure(self, clip: ChosenClip) -> None:
        """Add the rows of a clip."""
        try:
            then, stored = self._read(clip)
            body = self._read_body(then, stored)
            source = FrameQuantities(then, stored, body)
            ranges = self._ranges(then, stored, source, clip)
        except _LACKS as error:
            self._left_out.add(f"Left out: {error.what.rstrip('.')}", clip.document)
            return
        if not ranges:
            self._left_out.add(f"Left out: {self._without_ranges()}", stored.name)
            return
        facts = self._describe(then, stored)
        for asked in self._asked:
            self._measure_quantity(asked, facts, source, ranges)
        require_rows(len(self._rows))

    def finish(self, documents: int) -> Measured:
        """Compare the rows of each group; return all."""
        for group in self._groups.values():
            _score(group)
        order = {id(row): place for place, row in enumerate(self._rows)}
        self._rows.sort(key=lambda row: (-row.score if row.is_outlier else 0.0, order[id(row)]))
        measured = len({row.clip.document for row in self._rows})
        warnings = [*self._left_out.warnings(documents), *self._guessed.warnings(documents)]
        few = sum(0 < len(group.rows) < 4 for group in self._groups.values())
        if few:
            warnings.append(f"{few:,} of {len(self._groups):,} groups have no scores: fewer than four ranges.")
        return Measured(self._rows, list(self._groups.values()), measured, self._request.by, warnings)

    def _read(self, clip: ChosenClip) -> tuple[Transaction, StoredDocument]:
        stored = self._tx.documents.get(clip.document)
        if stored.revision == clip.revision:
            return self._tx, stored
        then = self._tx.at_commit(self._tx.documents.commit_of(stored.key, clip.revision))
        return then, then.documents.get(clip.document)

    def _ranges(
        self, tx: Transaction, stored: StoredDocument, source: FrameQuantities, clip: ChosenClip
    ) -> list[Range]:
        if clip.found is not None:
            return [Range.of_frames(first, last) for first, last in clip.found]
        if self._request.cycles:
            return list(ranges_of_labels(tx.spans.of(stored.key), self._request.cycles))
        if self._request.strides:
            seconds_of(stored)
            return list(ranges_of_strides(source.measure_gait(), stored.frames))
        return [Range.of_frames(1, stored.frames)] if stored.frames else []

    def _without_ranges(self) -> str:
        if self._request.cycles:
            return f"no complete cycle of {' or '.join(self._request.cycles)}"
        return "no stride" if self._request.strides else "no frames"

    def _describe(self, tx: Transaction, stored: StoredDocument) -> ClipFacts:
        properties: dict[str, str] = {}
        if any(key.startswith(_PROPERTY) for key in self._request.by):
            head = to_head(tx.heads.document(stored), stored.frame_time)
            properties = {name: str(value) for name, value, _ in head.properties}
        return ClipFacts(
            stored.uuid, stored.name, stored.project, stored.revision, stored.seconds_per_frame, properties
        )

    def _measure_quantity(
        self, asked: AskedQuantity, facts: ClipFacts, source: FrameQuantities, ranges: Sequence[Range]
    ) -> None:
        sides = sides_of(asked)
        own = [each for each in ranges if not each.side or each.side in sides]
        if not own:
            self._left_out.add(f"Left out of {asked.text}: no stride of its side", facts.name)
            return
        guesses = find_guesses(asked, source.body)
        if guesses and self._request.guesses == "no":
            self._left_out.add(f"Left out of {asked.text}: a guessed {' and '.join(guesses)}", facts.name)
            return
        unit = self._unit(asked, facts, source)
        if unit is None:
            return
        first = int(np.floor(min(each.begin for each in own))) + 1
        last = int(np.ceil(max(each.end for each in own))) + 1
        try:
            values = quantity_columns(source, [asked], first, last)[:, 0]
        except _LACKS as error:
            self._left_out.add(f"Left out of {asked.text}: {error.what.rstrip('.')}", facts.name)
            return
        unknown = 0
        for each in own:
            figures = summarise_samples(values[each.first - first : each.last - first + 1])
            if figures is None:
                unknown += 1
                continue
            self._add(asked, unit, facts, each, figures, normalise_range(values, *_places(each, first)))
        if unknown:
            some = "Left out of" if unknown == len(own) else "Some ranges are left out of"
            self._left_out.add(f"{some} {asked.text}: {find_reason(asked, source.body)}", facts.name)
        if guesses and unknown < len(own):
            why = f"{asked.text} depends on a guessed {' and '.join(guesses)}; guesses=no leaves it out"
            self._guessed.add(why, facts.name)

    def _unit(self, asked: AskedQuantity, facts: ClipFacts, source: FrameQuantities) -> str | None:
        """The unit of a quantity, None where the file lacks it or another clip has it in another unit."""
        try:
            (unit,) = source.units([asked])
        except _LACKS as error:
            self._left_out.add(f"Left out of {asked.text}: {error.what.rstrip('.')}", facts.name)
            return None
        if self._units.setdefault(asked.text, unit) == unit:
            return unit
        known = self._units[asked.text] or "no unit"
        self._left_out.add(f"Left out of {asked.text}: it is in {unit or 'no unit'}, not in {known}", facts.name)
        return None

    def _add(
        self, asked: AskedQuantity, unit: str, facts: ClipFacts, each: Range, figures: Figures, curve: Array
    ) -> None:
        values = {key: value_of(key, asked, facts, each) for key in self._request.by}
        place = (asked.text, *(facts.document if key == "clip" else value for key, value in values.items()))
        group = self._groups.setdefault(place, RangeGroup(asked, unit, values))
        if len(self._groups) > MOST_GROUPS:
            raise SizeError(
                f"There are more than {MOST_GROUPS:,} groups.", remedy="Group by fewer keys, or narrow the selection."
            )
        row = RangeFigures(facts, group, each, figures, curve if self._with_curves else None)
        group.curves.add(curve)
        group.rows.append(row)
        self._rows.append(row)


def _places(each: Range, first: int) -> tuple[float, float]:
    return each.begin - (first - 1), each.end - (first - 1)


def side_of(asked: AskedQuantity, each: Range) -> str:
    """The side of a stride, else of the joints of a quantity; "" for both or none."""
    sides = sides_of(asked)
    return each.side or (sides[0] if len(sides) == 1 else "")


def value_of(key: str, asked: AskedQuantity, facts: ClipFacts, each: Range) -> str:
    if key.startswith(_PROPERTY):
        return facts.properties.get(key.removeprefix(_PROPERTY), "")
    if key == "side":
        return side_of(asked, each)
    if key == "person":
        # Markers of several people have their prefixes: "Anna:RHEE".
        return next((text.rpartition(":")[0] for text in asked.arguments if ":" in text), "")
    return {"clip": facts.name, "project": facts.project, "label": each.label}[key]


def _score(group: RangeGroup) -> None:
    """Set the largest modified z-score of each row, and the figure that has it."""
    values = np.array([[getattr(row.figures, name) for name in FIGURES] for row in group.rows])
    scores = np.abs(np.stack([score_outliers(column) for column in values.T], axis=1))
    if np.isnan(scores).any():
        return
    worst = scores.argmax(axis=1)
    for row, place, score in zip(group.rows, worst.tolist(), scores.max(axis=1).tolist(), strict=True):
        row.score, row.score_of = score, FIGURES[place]


def summarise_group(group: RangeGroup) -> dict[str, tuple[float, float]]:
    """Return mean and standard deviation (n - 1; NaN for one range) of each figure over the ranges of a group."""
    values = np.array([[getattr(row.figures, name) for name in FIGURES] for row in group.rows])
    means = values.mean(axis=0)
    deviations = values.std(axis=0, ddof=1) if len(values) > 1 else np.full(len(FIGURES), np.nan)
    return dict(zip(FIGURES, zip(means.tolist(), deviations.tolist(), strict=True), strict=True))
