"""A clip of markers as TRC."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.formats.format import need_seconds
from mcml.formats.text.lines import encoded
from mcml.formats.text.number_text import rows_of_text
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.skeleton import CHANNEL_INDEX, CHANNELS, TRANSLATIONS, Array

KEYWORDS = (
    "DataRate",
    "CameraRate",
    "NumFrames",
    "NumMarkers",
    "Units",
    "OrigDataRate",
    "OrigDataStartFrame",
    "OrigNumFrames",
)
_LONGEST_DECIMALS = 9
_OF_RATES = ("datarate", "camerarate", "origdatarate", "time")


def write_trc(clip: ClipStream) -> Iterator[bytes]:
    """Write the file, row by row. Raises ConversionError without a frame time.

    Rates and counts that TRC repeats (CameraRate, OrigDataRate …) are the source's if it was TRC too.
    """
    head = clip.head
    source = next((part for part in head.sources if part.part == "trc"), None)
    said = _still_true(dict(source.sections), head) if source else {}
    seconds = head.seconds_per_frame() if "DataRate" in said else need_seconds(head, "TRC")
    codec = source.encoding if source else "utf-8"
    if not head.fields.get("calibration_unit"):
        raise ConversionError(
            "TRC says its unit of length, and the document does not: OpenSim refuses files without Units",
            remedy="State it once with `unit`: mcml set ID --unit mm, or PATCH the document.",
        )
    other = {name for joint in head.skeleton.joints for name in joint.channels} - set(TRANSLATIONS)
    if other:
        clip.notices.append(Notice("warning", f"TRC has no place for {', '.join(sorted(other, key=CHANNELS.index))}"))
    frames = clip.frames if clip.frames is not None else sum(len(block) for block in clip.blocks())
    keywords = source.keywords if source else KEYWORDS
    if "units" not in [word.lower() for word in keywords]:
        keywords = (*keywords, "Units")
    first = _first_frame(clip)
    text = _head(head, said, keywords, frames, seconds, first)
    yield encoded(text, codec, clip.notices)
    seconds = seconds or 0.0
    decimals, start = _time(said, seconds, first)
    moving = [(joint, CHANNEL_INDEX[name]) for joint in range(len(head.skeleton)) for name in TRANSLATIONS]
    done = 0
    for block in clip.blocks():
        times: Array = start + np.arange(done, done + len(block), dtype=np.float64) * seconds
        if not np.isfinite(times[-1:]).all():
            raise ConversionError(
                f"the times of the frames are beyond the largest number, at {seconds:g} seconds each",
                remedy="State another frame time first.",
            )
        yield _rows(block, moving, head.number_style, times, decimals, closes=source is None)
        done += len(block)


def time_of_first_frame(clip: ClipStream) -> float:
    """Return the time in seconds of the first frame of a clip. Raises ConversionError without a frame time."""
    source = next((part for part in clip.head.sources if part.part == "trc"), None)
    said = _still_true(dict(source.sections), clip.head) if source else {}
    return _time(said, need_seconds(clip.head, "TRC"), _first_frame(clip))[1]


def _still_true(said: dict[str, str], head: ClipHead) -> dict[str, str]:
    """The texts of a TRC's head, without rates and times where the frame time says another rate now."""
    if head.rate_text() == head.fields.get("dataframe_rate"):
        return said
    return {word: text for word, text in said.items() if word.lower() not in _OF_RATES}


def _head(
    head: ClipHead, said: dict[str, str], keywords: tuple[str, ...], frames: int, seconds: float | None, first: int
) -> str:
    rate = head.rate_text() or head.fields.get("dataframe_rate", "")
    facts = {
        "datarate": rate,
        "camerarate": rate,
        "numframes": str(frames),
        "nummarkers": str(len(head.skeleton)),
        "units": head.fields.get("calibration_unit", ""),
        "origdatarate": rate,
        "origdatastartframe": str(first),
        "orignumframes": str(frames),
    }
    texts = [said.get(word) or facts.get(word.lower(), "") for word in keywords]
    labels = "\t".join(f"{joint.source_name}\t\t" for joint in head.skeleton.joints)
    axes = "\t".join(f"X{number}\tY{number}\tZ{number}" for number in range(1, len(head.skeleton) + 1))
    name = head.fields.get("filename", "")
    lines = [
        f"PathFileType\t{head.fields.get('version', '4')}\t{said.get('axes', '(X/Y/Z)')}\t{name}",
        "\t".join(keywords),
        "\t".join(texts),
        f"Frame#\tTime\t{labels}",
        f"\t\t{axes}",
        "",
    ]
    return "\n".join(lines) + "\n"


def _first_frame(clip: ClipStream) -> int:
    """The number of the first frame; 1 where it has none that is a positive number."""
    block = next((block for block in clip.blocks() if len(block)), None)
    return int(block.ids[0]) if block is not None and not isinstance(block.ids, list) and block.ids[0] > 0 else 1


def _time(said: dict[str, str], seconds: float, first: int) -> tuple[int, float]:
    """Return (decimals, time of the first frame). Frame 1 is at 0, unless a TRC stated the time of its first frame."""
    words = said.get("Time", "").split()
    if len(words) == 2:
        return int(words[0]), float(words[1])
    if len(words) == 3:
        return int(words[0]), float(words[1]) + (first - int(words[2])) * seconds
    text = f"{seconds:.{_LONGEST_DECIMALS}f}".rstrip("0")
    return max(3, len(text.partition(".")[2])), (first - 1) * seconds


def _rows(
    block: FrameBlock, moving: list[tuple[int, int]], style: str, times: Array, decimals: int, *, closes: bool
) -> bytes:
    """closes: whether an empty cell at the end of a line gets a tab, without which OpenSim does not count it."""
    place = {column: index for index, column in enumerate(block.columns)}
    values = np.full((len(block), len(moving)), np.nan)
    for index, column in enumerate(moving):
        if column in place:
            values[:, index] = block.values[:, place[column]]
    missing = np.isnan(values)
    texts = rows_of_text(np.where(missing, 0.0, values), style, "\t")
    ids = block.ids if isinstance(block.ids, list) else block.ids.tolist()
    lines = []
    for row, (text, frame, time) in enumerate(zip(texts, ids, times.tolist(), strict=True)):
        if missing[row].any():
            cells = text.split(b"\t")
            text = b"\t".join(b"" if gone else cell for cell, gone in zip(cells, missing[row].tolist(), strict=True))
            text += b"\t" if closes and missing[row, -1] else b""
        lines.append(b"%s\t%.*f\t%s\n" % (str(frame).encode(), decimals, time, text))
    return b"".join(lines)
