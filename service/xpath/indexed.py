"""Runs a plan on rows and indexes: which frames, then which of their elements, counted without being read.

A result is a list of segments, each so many frames that all give the same number of items. Pages, counts and runs are
arithmetic on segments; only the frames of the page are read.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import orjson

from service.mcml.lexical import escape, unescape
from service.mcml.writer import write_frame_bone, write_frames
from service.motion.clip import Shape
from service.motion.skeleton import CHANNEL_INDEX
from service.storage.database import Transaction
from service.storage.documents import DocumentFilter, StoredDocument
from service.storage.motion_names import names_of_frames
from service.storage.runs import intersection, total
from service.xpath.nodes import Node, Run, Scope
from service.xpath.plan import Plan

ALL = 1 << 30


@dataclass(frozen=True, slots=True)
class Segment:
    """Frames first to last of a document. items: (ordinal from 1, bone, channel bits) that each gives; for whole frames
    or their ids one item with ordinal 0."""

    stored: StoredDocument
    first: int
    last: int
    items: tuple[tuple[int, int, int], ...]

    @property
    def frames(self) -> int:
        return self.last - self.first + 1

    @property
    def size(self) -> int:
        return self.frames * len(self.items)


class Indexed:
    """The answer of a plan over a scope, in one read transaction."""

    def __init__(self, tx: Transaction, plan: Plan, scope: Scope) -> None:
        self.tx = tx
        self.plan = plan
        self.scope = scope
        self._by_key: dict[int, list[tuple[int, int]]] | None = None
        self._stored: dict[int, StoredDocument] | None = None

    # Plain attributes: before Python 3.12 a cached_property lets one thread compute at a time, in all queries together.
    @property
    def by_key(self) -> dict[int, list[tuple[int, int]]]:
        """Frames of each document that has any, as ascending ranges (first, last), by document key."""
        if self._by_key is None:
            self._by_key = self._find()
        return self._by_key

    def _find(self) -> dict[int, list[tuple[int, int]]]:
        plan, scope = self.plan, self.scope
        if plan.motion_names:
            groups = [
                self.tx.spans.named([unescape(name) for name in group], scope.keys, scope.project)
                for group in plan.motion_names
            ]
            found = groups[0]
            for named in groups[1:]:
                found = {key: intersection(ranges, named[key]) for key, ranges in found.items() if key in named}
        else:
            found = {stored.key: [(1, stored.frames)] for stored in self._documents.values() if stored.frames}
        if plan.position is not None:
            found = {key: intersection(ranges, [(plan.position, plan.position)]) for key, ranges in found.items()}
        if plan.nth is not None:
            found = {key: _nth(ranges, plan.nth) for key, ranges in found.items()}
        return {key: ranges for key, ranges in found.items() if ranges}

    @property
    def _documents(self) -> dict[int, StoredDocument]:
        if self._stored is None:
            if self.plan.motion_names:
                self._stored = self.tx.documents.by_keys(list(self.by_key))
            else:
                self._stored = {stored.key: stored for stored in scope_documents(self.tx, self.scope)}
        return self._stored

    @property
    def ranges(self) -> list[tuple[StoredDocument, list[tuple[int, int]]]]:
        """Documents in order of the answer, with their ranges."""
        documents = sorted(self._documents.values(), key=lambda stored: (stored.name, stored.key))
        return [(stored, self.by_key[stored.key]) for stored in documents if stored.key in self.by_key]

    def segments(self) -> Iterator[Segment]:
        """The segments of the answer in order; those that give nothing are left out."""
        for stored, ranges in self.ranges:
            if not self.plan.bones:
                whole = ((0, 0, 0),)
                yield from (Segment(stored, first, last, whole) for first, last in ranges)
                continue
            wanted = None
            if self.plan.bone is not None:
                names = self.tx.heads.bone_names(stored.key)
                wanted = next((number for number, name in names.items() if escape(name) == self.plan.bone), None)
                if wanted is None:
                    continue
            for first, last, shape in self.tx.tracks.shape_ranges(stored.key, ranges):
                items = self._items(shape, wanted)
                if items:
                    yield Segment(stored, first, last, items)

    def _items(self, shape: Shape, wanted: int | None) -> tuple[tuple[int, int, int], ...]:
        attribute, ordinal = self.plan.attribute, self.plan.ordinal
        bit = 1 << CHANNEL_INDEX[attribute] if attribute in CHANNEL_INDEX else 0
        return tuple(
            (number, bone, bits)
            for number, (bone, bits) in enumerate(shape, 1)
            if (wanted is None or bone == wanted) and (ordinal is None or number == ordinal) and (not bit or bits & bit)
        )

    def count(self) -> int:
        """How many nodes the answer has."""
        if self.plan.bones:
            found = sum(segment.size for segment in self.segments())
        else:
            found = sum(total(ranges) for ranges in self.by_key.values())
        if self.plan.nth_result is not None:
            return int(found >= self.plan.nth_result)
        return found

    def runs(self) -> Iterator[Run]:
        """Maximal ranges of frames that give at least one node."""
        waiting: Run | None = None
        for segment in self._chosen():
            run = Run(segment.stored, segment.first, segment.last)
            if waiting is not None and waiting.stored.key == run.stored.key and run.first == waiting.last + 1:
                waiting = Run(waiting.stored, waiting.first, run.last)
                continue
            if waiting is not None:
                yield waiting
            waiting = run
        if waiting is not None:
            yield waiting

    def _chosen(self) -> Iterator[Segment]:
        """The segments, cut to the nth result where the plan asks for one."""
        nth = self.plan.nth_result
        if nth is None:
            yield from self.segments()
            return
        skipped = 0
        for segment in self.segments():
            if skipped + segment.size < nth:
                skipped += segment.size
                continue
            frame, item = divmod(nth - skipped - 1, len(segment.items))
            position = segment.first + frame
            yield replace(segment, first=position, last=position, items=(segment.items[item],))
            return

    def nodes(self, offset: int, limit: int) -> list[Node]:
        """The nodes of a page."""
        result: list[Node] = []
        skipped = 0
        for segment in self._chosen():
            if skipped + segment.size <= offset:
                skipped += segment.size
                continue
            begin = max(offset - skipped, 0)
            end = min(segment.size, begin + limit - len(result))
            result += self._read(segment, begin, end)
            skipped += segment.size
            if len(result) >= limit:
                break
        return result

    def _read(self, segment: Segment, begin: int, end: int) -> list[Node]:
        """Items begin to end - 1 of a segment, counted over its frames."""
        width = len(segment.items)
        first, last = segment.first + begin // width, segment.first + (end - 1) // width
        nodes = self._bones(segment, first, last) if self.plan.bones else self._frames(segment, first, last)
        start = begin - (first - segment.first) * width
        return nodes[start : start + end - begin]

    def _frames(self, segment: Segment, first: int, last: int) -> list[Node]:
        stored = segment.stored
        if self.plan.attribute is not None:
            ids = self.tx.tracks.frame_ids(stored.key, first, last)
            return [
                Node("attribute", stored, f"/mcml/motion/frame[{position}]/@id", str(text))
                for position, text in enumerate(ids, first)
            ]
        result: list[Node] = []
        names = self.tx.heads.bone_names(stored.key)
        by_number = [names.get(number, "") for number in range(max(names, default=-1) + 1)]
        position = first
        for block in self.tx.tracks.blocks(stored.key, first, last):
            spans = self.tx.spans.of(stored.key, position, position + len(block) - 1)
            labels = names_of_frames(spans, range(position, position + len(block)))
            text = b"".join(write_frames(replace(block, motion_names=labels), by_number)).decode()
            for xml in text.split("</frame>\n")[:-1]:
                result.append(Node("element", stored, f"/mcml/motion/frame[{position}]", xml + "</frame>"))
                position += 1
        return result

    def _bones(self, segment: Segment, first: int, last: int) -> list[Node]:
        stored, attribute = segment.stored, self.plan.attribute
        names = self.tx.heads.bone_names(stored.key)
        result: list[Node] = []
        position = first
        wanted = sorted({bone for _, bone, _ in segment.items})
        for block in self.tx.tracks.blocks(stored.key, first, last, bones=wanted):
            place = {column: index for index, column in enumerate(block.columns)}
            for row in block.values.tolist():
                for ordinal, bone, bits in segment.items:
                    address = f"/mcml/motion/frame[{position}]/frame_bone[{ordinal}]"
                    if attribute == "name":
                        result.append(Node("attribute", stored, f"{address}/@name", escape(names[bone])))
                    elif attribute is not None:
                        value = orjson.dumps(row[place[bone, CHANNEL_INDEX[attribute]]]).decode()
                        result.append(Node("attribute", stored, f"{address}/@{attribute}", value))
                    else:
                        values = [row[place[bone, channel]] for channel in range(8) if bits >> channel & 1]
                        xml = write_frame_bone(names[bone], bits, values).decode()
                        result.append(Node("element", stored, address, xml))
                position += 1
        return result


def scope_documents(tx: Transaction, scope: Scope) -> list[StoredDocument]:
    """The documents of a scope, by name, then key."""
    if scope.keys is not None:
        found = tx.documents.by_keys(scope.keys)
        return sorted(found.values(), key=lambda stored: (stored.name, stored.key))
    return tx.documents.page(DocumentFilter(project=scope.project_name), after=None, limit=ALL)


def _nth(ranges: Sequence[tuple[int, int]], nth: int) -> list[tuple[int, int]]:
    left = nth
    for first, last in ranges:
        if left <= last - first + 1:
            return [(first + left - 1, first + left - 1)]
        left -= last - first + 1
    return []


_FRAME = re.compile(r"/mcml/motion/frame(?:\[(\d+)\])?(?:/|$)")


def frame_of(address: str) -> int | None:
    """The position of the frame that a node is or lies in, None outside the motion's frames."""
    match = _FRAME.match(address)
    return None if match is None else int(match[1] or 1)
