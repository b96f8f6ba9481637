"""The contract of formats: a subclass with samples tests all of it."""

from __future__ import annotations

import io
import random
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest

from mcml.errors import ConversionError, FormatError, LimitError, McmlError, UnsupportedError
from mcml.formats import FORMATS, find_format
from mcml.formats.format import Format, Limits, ReadOptions, SourceFile
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.skeleton import CHANNELS

Files = Mapping[str, bytes]


def read(format: Format, files: Files, options: ReadOptions | None = None) -> ClipStream:
    """The clip that bytes by part hold."""
    sources = {part: SourceFile(f"clip.{part}", io.BytesIO(data)) for part, data in files.items()}
    return format.read(sources, options or ReadOptions())


def written(format: Format, clip: ClipStream) -> dict[str, bytes]:
    """Every part of a clip as bytes."""
    parts = [part.name for part in format.parts]
    if clip.frames == 0 and len(parts) > 1:
        parts = parts[:1]
    return {part: b"".join(format.write(clip, part)) for part in parts}


def frames(clip: ClipStream) -> list[tuple[object, tuple[tuple[int, tuple[tuple[int, bytes], ...]], ...]]]:
    """Every frame as (id, bones in order with the bits of each value): nothing is left out of the comparison."""
    result = []
    for block in clip.blocks():
        check_block(block)
        place = {column: index for index, column in enumerate(block.columns)}
        ids = block.ids if isinstance(block.ids, list) else block.ids.tolist()
        for row, frame_id in enumerate(ids):
            shape = block.shapes[0 if block.shape_of is None else int(block.shape_of[row])]
            bones = tuple(
                (
                    joint,
                    tuple(
                        (c, block.values[row, place[joint, c]].tobytes()) for c in range(len(CHANNELS)) if bits >> c & 1
                    ),
                )
                for joint, bits in shape
            )
            result.append((frame_id, bones))
    return result


def check_block(block: FrameBlock) -> None:
    """Check that a block keeps the contract of `FrameBlock`: finite exactly where a frame's shape has the channel."""
    assert block.values.shape == (len(block.ids), len(block.columns))
    assert len(set(block.columns)) == len(block.columns)
    for row in range(len(block)):
        shape = dict(block.shapes[0 if block.shape_of is None else int(block.shape_of[row])])
        has = [bool(shape.get(joint, 0) >> channel & 1) for joint, channel in block.columns]
        assert (np.isfinite(block.values[row]) == has).all()


class FormatContract:
    """The contract of a format.

    name: of the format in the catalogue. samples: small files, by their feature; each must be readable.
    """

    name: str
    samples: Mapping[str, Files]

    @property
    def format(self) -> Format:
        return FORMATS[self.name]

    def cases(self) -> Iterator[Files]:
        yield from self.samples.values()

    def test_a_clip_leaves_as_it_came(self) -> None:
        for title, files in self.samples.items():
            clip = read(self.format, files)
            again = read(self.format, written(self.format, clip))
            assert _without_names(again) == _without_names(clip), title
            assert frames(again) == frames(clip), title

    def test_the_shortest_style_keeps_every_bit(self) -> None:
        for title, files in self.samples.items():
            clip = read(self.format, files)
            plain = clip.with_head(replace(clip.head, number_style="shortest"))
            assert frames(read(self.format, written(self.format, plain))) == frames(clip), title

    def test_any_style_keeps_every_bit(self) -> None:
        for style in ("fixed:2", "general:4"):
            for title, files in self.samples.items():
                clip = read(self.format, files)
                styled = clip.with_head(replace(clip.head, number_style=style))
                assert frames(read(self.format, written(self.format, styled))) == frames(clip), (title, style)

    def test_frames_can_be_read_again(self) -> None:
        for title, files in self.samples.items():
            clip = read(self.format, files)
            first = frames(clip)
            notices = list(clip.notices)
            assert frames(clip) == first, title
            assert clip.notices == notices, title
            assert clip.frames in (None, len(first)), title

    def test_a_file_cut_anywhere_is_refused_or_shorter(self) -> None:
        for files in self.samples.values():
            whole = len(frames(read(self.format, files)))
            for part, data in files.items():
                for end in range(len(data)):
                    try:
                        found = frames(read(self.format, {**files, part: data[:end]}))
                    except (FormatError, UnsupportedError):
                        continue
                    assert len(found) <= whole

    def test_any_byte_may_be_wrong(self) -> None:
        chance = random.Random(20)
        for files in self.samples.values():
            for part, data in files.items():
                for _ in range(150):
                    spoilt = bytearray(data)
                    for _ in range(chance.choice((1, 1, 4))):
                        spoilt[chance.randrange(len(spoilt))] = chance.choice(
                            (0, 10, 13, 32, 35, 44, 45, 48, 57, 123, 125, 255, chance.randrange(256))
                        )
                    self._reads_or_refuses({**files, part: bytes(spoilt)})

    def test_lines_may_be_lost_doubled_or_swapped(self) -> None:
        chance = random.Random(21)
        for files in self.samples.values():
            for part, data in files.items():
                lines = data.splitlines(keepends=True)
                for _ in range(150):
                    changed = list(lines)
                    place = chance.randrange(len(changed))
                    match chance.randrange(3):
                        case 0:
                            del changed[place]
                        case 1:
                            changed.insert(chance.randrange(len(changed)), changed[place])
                        case _:
                            other = chance.randrange(len(changed))
                            changed[place], changed[other] = changed[other], changed[place]
                    self._reads_or_refuses({**files, part: b"".join(changed)})

    @pytest.mark.parametrize("decimals", [80, 99, 100, 101, 390])
    def test_numbers_may_have_any_number_of_decimals(self, decimals: int) -> None:
        for title, files in self.samples.items():
            longer = {
                part: re.sub(rb"(?<![\w.])-?\d+\.\d+(?![\w.])", lambda found: _padded(found[0], decimals), data)
                for part, data in files.items()
            }
            clip = read(self.format, longer)
            assert frames(clip) == frames(read(self.format, files)), title
            assert frames(read(self.format, written(self.format, clip))) == frames(clip), title

    def test_junk_is_refused(self) -> None:
        chance = random.Random(22)
        junk = [
            b"",
            b" ",
            b"\n\n",
            b"\0" * 100,
            b"\xff\xfe" + "text".encode("utf-16-le"),
            b"{}",
            b"a" * 5000,
            b"#" * 99,
        ]
        junk += [chance.randbytes(size) for size in (1, 10, 1000)]
        for files in self.samples.values():
            for part in files:
                for data in junk:
                    with pytest.raises(McmlError):
                        frames(read(self.format, {**files, part: data}))

    def test_limits_are_checked_before_memory_is_taken(self) -> None:
        files = next(iter(self.samples.values()))
        for limits in (Limits(joints=1), Limits(depth=0), Limits(name=1), Limits(frames=1), Limits(values=1)):
            with pytest.raises(LimitError):
                frames(read(self.format, files, ReadOptions(limits=limits)))

    def test_line_ends_and_byte_order_mark_do_not_matter(self) -> None:
        for title, files in self.samples.items():
            plain = {part: data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") for part, data in files.items()}
            expected = frames(read(self.format, plain))
            for change in (b"\r\n", b"\r"):
                changed = {part: data.replace(b"\n", change) for part, data in plain.items()}
                assert frames(read(self.format, changed)) == expected, (title, change)
            marked = {part: b"\xef\xbb\xbf" + data for part, data in plain.items()}
            if all(data.isascii() for data in plain.values()):
                clip = read(self.format, marked)
                assert frames(clip) == expected, title
                assert any("byte order mark" in notice.what for notice in clip.notices)
                assert all(data.startswith(b"\xef\xbb\xbf") for data in written(self.format, clip).values())

    def test_the_last_line_may_lack_its_end(self) -> None:
        for title, files in self.samples.items():
            expected = frames(read(self.format, files))
            stripped = {part: data.rstrip() for part, data in files.items()}
            assert frames(read(self.format, stripped)) == expected, title

    def test_the_file_is_recognised(self) -> None:
        for files in self.samples.values():
            for part, data in files.items():
                found, found_part = find_format(f"clip.{part}", data[:4096])
                assert (found.name, found_part) == (self.name, part)

    def _reads_or_refuses(self, files: Files) -> None:
        try:
            clip = read(self.format, files)
            read_frames = frames(clip)
        except McmlError:
            return
        # A clip that was read can be written and read again with the same values, unless its unit or rate was damaged.
        try:
            files = written(self.format, clip)
        except ConversionError as error:
            if "the document does not" not in str(error):
                raise
            return
        again = read(self.format, files)
        assert [frame[1] for frame in frames(again)] == [frame[1] for frame in read_frames]


def _padded(number: bytes, decimals: int) -> bytes:
    return number + b"0" * (decimals - len(number.split(b".")[1]))


def _without_names(clip: ClipStream) -> object:
    return replace(clip.head, sources=tuple(replace(source, name="") for source in clip.head.sources))
