"""TRC: the contract, and every quirk of real files."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from mcml.errors import ConversionError, FormatError
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Convention
from mcml.testing import FormatContract, frames, read, written
from tests.builders import ASF, TRC, amc, bvh, c3d_file

TEXT = TRC.decode()
HEAD, ROWS = TEXT.split("\n\n")


def clip_of(text: str = TEXT) -> ClipStream:
    return read(FORMATS["trc"], {"trc": text.encode()})


def notices(text: str) -> str:
    clip = clip_of(text)
    frames(clip)
    return "\n".join(notice.what for notice in clip.notices)


def table(clip: ClipStream) -> np.ndarray:
    return np.concatenate([block.values for block in clip.blocks()])


class TestTrc(FormatContract):
    name = "trc"
    samples: ClassVar = {
        "gaps": {"trc": TRC},
        "none": {"trc": (HEAD + "\n\n" + ROWS.splitlines()[0] + "\n").encode()},
        "exponents": {"trc": TEXT.replace("273.71817", "2.7371817e+002").encode()},
        "partly missing": {"trc": TEXT.replace("\t-56.52052\t", "\t\t").encode()},
        "no frame": {"trc": (HEAD + "\n\n").replace("\t4\t3\tmm", "\t0\t3\tmm").encode()},
        "latin": {"trc": TEXT.replace("R.Wrist", "für").encode("latin-1")},
    }


def test_keeps_what_the_file_says() -> None:
    clip = clip_of()
    assert [joint.source_name for joint in clip.head.skeleton.joints] == ["R.Wrist", "*0", "R.Wrist"]
    assert clip.head.skeleton.names == ("R.Wrist", "*0", "R.Wrist#2")
    assert {joint.convention for joint in clip.head.skeleton.joints} == {Convention.MARKER}
    fields = clip.head.fields
    assert (fields["dataframe_rate"], fields["calibration_unit"], fields["filename"]) == ("120.00", "mm", "hand.trc")
    assert clip.head.number_style == "fixed:5"
    (block,) = clip.blocks()
    assert block.ids.tolist() == [11, 12, 13, 14]  # type: ignore[union-attr]
    assert np.isnan(block.values[1, 3:6]).all()
    assert np.isnan(block.values[2, :3]).all()
    assert not np.isnan(block.values[0]).any()
    assert clip.notices == []


def test_leaves_as_it_came() -> None:
    assert written(FORMATS["trc"], clip_of()) == {"trc": TRC}


@pytest.mark.parametrize("missing", ["nan", "NaN", "NAN", " "])
def test_words_for_missing(missing: str) -> None:
    other = TEXT.replace("\t\t\t\t4.00000", f"\t{missing}\t{missing}\t{missing}\t4.00000")
    assert other != TEXT
    assert frames(clip_of(other)) == frames(clip_of())


def test_a_gap_is_never_closed() -> None:
    """Split on single tabs: on runs of white space the next marker's numbers would move into the gap."""
    values = table(clip_of())
    assert values[1, 6:].tolist() == [4.0, 5.0, 6.0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("\t4\t3\tmm", "\t9\t3\tmm"), "NumFrames says 9, the file has 4 rows: these count"),
        (("\t4\t3\tmm", "\t4\t4\tmm"), "NumMarkers says 4, there are 3 labels: these count"),
        (("0.100", "0.200"), "the times do not follow from DataRate"),
        (("120.00\t120.00\t4", "0\t120.00\t4"), "'0' is no rate, and the times are even at 120 frames a second"),
    ],
)
def test_says_what_does_not_fit(change: tuple[str, str], said: str) -> None:
    other = TEXT.replace(*change, 1)
    assert other != TEXT
    assert said in notices(other)
    assert np.array_equal(table(clip_of(other)), table(clip_of()), equal_nan=True)


def with_times(times: list[str], rate: str) -> str:
    """A file with a row for each time."""
    row = ROWS.splitlines()[0].split("\t")
    rows = ["\t".join([str(number), time, *row[2:]]) for number, time in enumerate(times, 1)]
    head = HEAD.replace("120.00\t120.00\t4", f"{rate}\t120.00\t{len(times)}")
    return "\n".join([head, "", *rows]) + "\n"


@pytest.mark.parametrize("rate", [23.976, 25, 29.97, 50, 59.94, 60, 100, 119.88, 120, 240, 1000])
@pytest.mark.parametrize("decimals", [3, 4, 6, 9])
def test_times_that_are_even_decide_the_rate(rate: float, decimals: int) -> None:
    if rate * 10.0**-decimals > 0.5:
        return
    times = [f"{1.5 + frame / rate:.{decimals}f}" for frame in range(400)]
    clip = clip_of(with_times(times, "99.00"))
    assert 1 / float(clip.head.fields["dataframe_rate"]) == pytest.approx(1 / rate, abs=2.0 * 10.0**-decimals / 399)
    stated = f"DataRate says 99.00, and the times are even at {clip.head.fields['dataframe_rate']} frames a second"
    assert any(stated in notice.what for notice in clip.notices)
    if decimals == 6:
        assert float(clip.head.fields["dataframe_rate"]) == rate
    again = read(FORMATS["trc"], written(FORMATS["trc"], clip))
    assert again.head.fields == clip.head.fields
    assert not again.notices
    # Where DataRate is what the times say, nothing is said.
    assert not clip_of(with_times(times, f"{rate:.3f}")).notices


def test_times_that_were_rounded_and_filled_up_are_no_contradiction() -> None:
    times = [f"{round(frame / 60, 3):.6f}" for frame in range(30)]
    clip = clip_of(with_times(times, "60.00"))
    assert clip.head.fields["dataframe_rate"] == "60.00"
    assert not clip.notices


@pytest.mark.parametrize("times", ["0.0 0.1 0.3 0.35", "0.000 0.000 0.000", "0.000 0.5 nan", "0.00 9.00"])
def test_times_that_are_not_even_decide_nothing(times: str) -> None:
    for rate in ("120.00", "x"):
        clip = clip_of(with_times(times.split(), rate))
        assert clip.head.fields.get("dataframe_rate") == ("120.00" if rate != "x" else None)
        said = "do not follow from DataRate" if rate != "x" else "how fast the frames follow is unknown"
        assert any(said in notice.what for notice in clip.notices)


def test_columns_without_a_label_are_left_out_and_named() -> None:
    values = table(clip_of())
    # The label in the middle, that at the end, and one column that belongs to nothing.
    for gone, columns, kept in (("*0", "6-8", [0, 1, 2, 6, 7, 8]), ("R.Wrist\t\t\n", "9-11", [0, 1, 2, 3, 4, 5])):
        other = TEXT.replace(gone, "\t\t\n" if gone.endswith("\n") else "", 1)
        clip = clip_of(other)
        assert np.array_equal(table(clip), values[:, kept], equal_nan=True)
        said = [notice.what for notice in clip.notices]
        assert "NumMarkers says 3, there are 2 labels: these count" in said
        assert f"columns without a label were left out: {columns}" in said
        for count in ("2", "5"):
            counted = clip_of(other.replace("\t3\tmm", f"\t{count}\tmm"))
            assert np.array_equal(table(counted), values[:, kept], equal_nan=True)
    text = "\n".join(line + "\t77" if line[:1].isdigit() and line[2:3] == "\t" else line for line in TEXT.split("\n"))
    assert np.array_equal(table(clip_of(text)), values, equal_nan=True)
    assert "columns without a label were left out: 12" in notices(text)


def test_trailing_tabs_labels_two_columns_apart_and_blanks() -> None:
    plain = frames(clip_of())
    trailing = "\n".join(line + "\t" if line else line for line in TEXT.split("\n"))
    assert frames(clip_of(trailing)) == plain
    narrow = TEXT.replace("Time\tR.Wrist\t\t\t*0\t\t\tR.Wrist\t\t", "Time\t\tR.Wrist\t\t*0\t\tR.Wrist")
    assert frames(clip_of(narrow)) == plain
    row = ROWS.splitlines()[0]
    blanks = (HEAD + "\n" + row).replace("\t", " ").replace("hand.trc", "h") + "\n"
    assert frames(clip_of(blanks)) == plain[:1]
    assert "a missing sample cannot be seen" in notices(blanks)


def test_facts_between_two_tabs() -> None:
    lines = TEXT.split("\n")
    lines[2] = " " + lines[2].replace("\t", "\t\t  ")
    clip = clip_of("\n".join(lines))
    assert clip.head.fields == clip_of().head.fields
    assert clip.head.frame_time == clip_of().head.frame_time
    assert frames(clip) == frames(clip_of())
    assert written(FORMATS["trc"], clip)["trc"] == written(FORMATS["trc"], clip_of())["trc"]


@pytest.mark.parametrize(
    ("text", "said", "line"),
    [
        (TEXT.replace("PathFileType", "FileType"), "expected PathFileType", 1),
        (TEXT.replace("DataRate\tCamera", "Rate\tCamera", 1), "does not name DataRate", 2),
        (HEAD.split("Frame#")[0], "ends before the labels", 3),
        (TEXT.replace("Frame#", "Bild"), "expected Frame#, Time", 4),
        (TEXT.replace("-56.52053", "abc"), "frame 12, R.Wrist Y: 'abc' is not a finite number", 8),
        (TEXT.replace("-56.52053", "-56,52053"), "decimal comma", 8),
        (TEXT.replace("-56.52053", "inf"), "'inf' is not a finite number", 8),
        (TEXT.replace("12\t0.092", "x\t0.092"), "'x' is no frame number", 8),
        (TEXT.replace("6.00000\n13", "6.00000\t7.0\n13"), "frame 12 has 10 coordinates, the head says 9", 8),
    ],
)
def test_refuses_with_the_line(text: str, said: str, line: int) -> None:
    assert text != TEXT
    with pytest.raises(FormatError, match=said.replace(".", r"\.")) as caught:
        frames(clip_of(text))
    assert caught.value.at is not None
    assert caught.value.at.line == line


def test_without_a_rate_nothing_is_written() -> None:
    clip = read(FORMATS["asf-amc"], {"asf": ASF, "amc": amc()})
    with pytest.raises(ConversionError, match="how fast"):
        written(FORMATS["trc"], convert(clip, Convention.MARKER))


def test_joints_of_a_body_become_markers() -> None:
    body = read(FORMATS["bvh"], {"bvh": bvh(20)})
    body = body.with_head(replace(body.head, fields={"calibration_unit": "cm"}))
    positions = np.concatenate(
        [Walker(body.head.skeleton).poses(block)[0].reshape(len(block), -1) for block in body.blocks()]
    )
    out = written(FORMATS["trc"], convert(body, Convention.MARKER))
    again = read(FORMATS["trc"], out)
    assert again.head.skeleton.names == ("Root", "Spine", "Head")
    assert np.array_equal(table(again), positions)
    assert again.head.seconds_per_frame() == pytest.approx(0.0083333, rel=1e-9)


def test_markers_become_no_body() -> None:
    with pytest.raises(ConversionError, match="no skeleton"):
        convert(clip_of(), Convention.LISTED)


def obvious(path: Path) -> np.ndarray:
    """The cells of a real file by the csv module, missing ones NaN."""
    rows = list(csv.reader(io.StringIO(path.read_text(encoding="latin-1"), newline=""), delimiter="\t"))
    markers = len([cell for cell in rows[3][2:] if cell.strip()])
    found = []
    for row in rows[4:]:
        if row and row[0].strip().isdigit():
            cells = [cell.strip().lower() for cell in row[2 : 2 + 3 * markers]]
            found.append([float(cell) if cell not in ("", "nan") else np.nan for cell in cells])
    return np.array(found)


def test_real_files_by_another_reader(shared: Path) -> None:
    paths = [path for folder in ("trc", "trc_facial") for path in sorted((shared / folder).rglob("*.trc"))]
    compared = 0
    for path in paths:
        if "malformed" in path.parts:
            continue
        values = table(read(FORMATS["trc"], {"trc": path.read_bytes()}))
        assert np.array_equal(values, obvious(path), equal_nan=True), path.name
        compared += 1
    assert compared >= 13


def test_damaged_real_files_are_refused(shared: Path) -> None:
    for path in sorted((shared / "trc/malformed").glob("*.trc")):
        with pytest.raises(FormatError):
            frames(read(FORMATS["trc"], {"trc": path.read_bytes()}))


def test_a_file_without_a_unit_is_not_written() -> None:
    """OpenSim refuses it."""
    clip = read(FORMATS["trc"], {"trc": TRC.replace(b"\tmm", b"\t")}, ReadOptions())
    assert "calibration_unit" not in clip.head.fields
    with pytest.raises(ConversionError, match="unit of length") as caught:
        written(FORMATS["trc"], clip)
    assert "--unit" in (caught.value.remedy or "")


def test_frames_have_their_own_times() -> None:
    """A C3D that begins at frame 91 is at 0.9 s there; so is a TRC of which the first frames were cut away."""
    c3d = read(FORMATS["c3d"], {"c3d": c3d_file(rate=100.0, first=91)}, ReadOptions())
    c3d = c3d.with_head(replace(c3d.head, fields=c3d.head.fields | {"calibration_unit": "mm"}))
    text = written(FORMATS["trc"], c3d)["trc"].decode()
    assert [line.split("\t")[:2] for line in text.splitlines()[6:8]] == [["91", "0.900"], ["92", "0.910"]]
    facts = dict(zip(text.splitlines()[1].split("\t"), text.splitlines()[2].split("\t"), strict=True))
    assert facts["OrigDataStartFrame"] == "91"
    again = read(FORMATS["trc"], {"trc": text.encode()}, ReadOptions())
    [block] = list(again.blocks())
    shape_of = None if block.shape_of is None else block.shape_of[2:]
    rest = replace(block, values=block.values[2:], ids=block.ids[2:], shape_of=shape_of)
    later = written(FORMATS["trc"], ClipStream(again.head, lambda: iter([rest]), len(rest)))["trc"].decode()
    assert later.splitlines()[6].split("\t")[:2] == ["93", "0.920"]
