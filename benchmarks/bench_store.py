"""Loading, sizes, label counts and edits: SQLite store against BaseX (text and attribute index on), lxml, simdjson."""

from __future__ import annotations

import re
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import simdjson
from lxml import etree

from benchmarks import basex
from benchmarks.library import clips, load, load_together, longer, served, write_plain
from benchmarks.timing import median_seconds, report
from service.actions.edit_element import Change, change_element
from service.actions.read_clip import read_clip
from service.mcml.writer import write_document
from service.storage.database import Database
from service.storage.documents import DocumentFilter

ASKED = 100
"""Label counts timed, before an edit and after it; each with a constant not asked before."""

TIMES = 5
"""How much longer than the files at hand the clips of the usual library are."""


def run() -> dict[str, object]:
    what, files = clips()
    figures: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, library in (("short", files), ("usual", longer(files, TIMES))):
            text = sum(len(content) for _, content in library)
            said = what if name == "short" else f"{what}, each followed by {TIMES - 1} variations of itself"
            print(f"   {name}: {len(library)} {said}, {text / 1e6:.1f} MB")
            place = Path(folder) / name
            place.mkdir()
            figures[name] = _loading(place, library, text)
        url = f"sqlite:///{Path(folder) / 'usual' / 'store.db'}"
        database = Database(url)
        figures |= _writing(database)
        figures |= _large_file(Path(folder), files)
        if basex.available():
            figures |= _against_basex(Path(folder), figures)
        else:
            print("   BaseX is not installed (Debian package basex): its ratios are left out")
        with served(url) as client:
            figures["label_count_above_empty_ms"] = report(
                "label count over HTTP, ms above the same route asked q=1", _counts(client, first=0), "<= 1"
            )
            figures["edit_ms"] = report("one value of one frame_bone edited, ms", _edit(database) * 1e3)
            figures["label_count_above_empty_after_edit_ms"] = report(
                "the same count after an edit", _counts(client, first=ASKED), "<= 1"
            )
        database.close()
    return figures


def _loading(folder: Path, files: list[tuple[str, bytes]], text: int) -> dict[str, float]:
    """Import of a library: time, sizes; leaves store.db and the documents as plain MCML in mcml/."""
    parse = _bare_parse(files)
    single, best = 1e9, 1e9
    for attempt in range(3):
        with _fresh_store(folder / f"single{attempt}.db") as timed:
            single = min(single, load(timed, files, labelled=False))
        with _fresh_store(folder / f"together{attempt}.db") as timed:
            best = min(best, load_together(timed, files))
    database = Database(f"sqlite:///{folder / 'store.db'}")
    database.migrate()
    load(database, files, labelled=True)
    sizes = database.size()
    (folder / "mcml").mkdir()
    with database.read() as tx:
        for stored in tx.documents.page(DocumentFilter(), after=None, limit=1000):
            write_plain(tx, stored, folder / "mcml" / f"{stored.uuid}.xml")
    database.close()
    lean = sizes["total"] - sizes["uploads"]
    return {
        "single_import_s": report("import file by file, upload kept, s (best of 3)", single),
        "single_MB_per_s": report("  MB of BVH a second", text / single / 1e6),
        "single_to_parse": report("  import / bare simdjson parse", single / parse, "<= 12"),
        "import_s": report("import of all in one call, upload kept, s (best of 3)", best),
        "import_MB_per_s": report("  MB of BVH a second", text / best / 1e6),
        "import_to_parse": report("  import / bare simdjson parse", best / parse, "<= 12"),
        "size_without_uploads": report("database without kept uploads / BVH text", lean / text, "<= 0.30"),
        "size_with_uploads": report("database with kept uploads / BVH text", sizes["total"] / text, "<= 0.62"),
        "bytes": float(sizes["total"]),
    }


@contextmanager
def _fresh_store(path: Path) -> Iterator[Database]:
    database = Database(f"sqlite:///{path}")
    database.migrate()
    yield database
    database.close()
    path.unlink()


def _bare_parse(files: list[tuple[str, bytes]]) -> float:
    """Seconds to parse the numbers alone with simdjson, the text made JSON beforehand."""
    parser = simdjson.Parser()
    texts = []
    for _, content in files:
        numbers = re.split(rb"Frame\s+Time:\s*\S+", content, flags=re.IGNORECASE)[1]
        joined = b",".join(re.sub(rb"^([-]?)\.", rb"\g<1>0.", token) for token in numbers.split())
        texts.append(b"[" + joined + b"]")

    def parse() -> None:
        for text in texts:
            parser.parse(text).as_buffer(of_type="d")

    return report("bare simdjson parse of all numbers, s", median_seconds(parse))


def _large_file(folder: Path, files: list[tuple[str, bytes]]) -> dict[str, float]:
    """One large clip: the biggest file, followed by variations of itself, to about 50 MB."""
    longest = max(files, key=lambda item: len(item[1]))
    ((name, big),) = longer([longest], max(1, 50_000_000 // len(longest[1])))
    parse = _bare_parse([(name, big)])
    best = 1e9
    for attempt in range(3):
        database = Database(f"sqlite:///{folder / f'large{attempt}.db'}")
        database.migrate()
        best = min(best, load(database, [(name, big)], labelled=False))
    figures = {"large_import_s": report(f"one clip of {len(big) / 1e6:.0f} MB, import s (best of 3)", best)}
    figures["large_import_to_parse"] = report("its import / bare simdjson parse", best / parse, "<= 12")
    if basex.available():
        target = folder / "large"
        target.mkdir()
        with database.read() as tx:
            (stored,) = tx.documents.page(DocumentFilter(), after=None, limit=1)
            write_plain(tx, stored, target / "large.xml")
        done = basex.run([f"CREATE DB one {target}"])
        loading = report("BaseX loads its MCML, s", done.created["one"] / 1e3)
        figures["large_basex_load_ratio"] = report("BaseX load / our import of it", loading / best, ">= 15")
    database.close()
    return figures


def _writing(database: Database) -> dict[str, float]:
    with database.read() as tx:
        stored = max(tx.documents.page(DocumentFilter(), after=None, limit=1000), key=lambda item: item.frames)
        source = read_clip(tx, stored)
        blocks = list(source.clip.blocks())

    def ours() -> None:
        for _ in write_document(source.document, stored.frames, stored.frame_time, blocks, source.names):
            pass

    def theirs() -> None:
        with tempfile.TemporaryFile() as target, etree.xmlfile(target) as out, out.element("motion"):
            for block in blocks:
                for frame_id, row in zip(block.ids, block.values.tolist(), strict=True):
                    with out.element("frame", id=str(frame_id)):
                        bones: dict[int, dict[str, str]] = {}
                        for (bone, channel), value in zip(block.columns, row, strict=True):
                            bones.setdefault(bone, {"name": source.names[bone]})[_CHANNELS[channel]] = repr(value)
                        for attributes in bones.values():
                            out.write(etree.Element("frame_bone", attributes))

    ratio = median_seconds(theirs, 3) / median_seconds(ours)
    return {"mcml_writing": report("MCML writing, times lxml's xmlfile", ratio, ">= 10")}


_CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF", "residual")


def _against_basex(folder: Path, figures: dict[str, Any]) -> dict[str, float]:
    """Both libraries loaded in one JVM (the short one twice, to warm it), label counts before and after an edit."""
    first = min((folder / "usual" / "mcml").glob("*.xml"))
    counts = [f"XQUERY count(//frame[motion_name='move-{number}'])" for number in range(30)]
    more = [f"XQUERY count(//frame[motion_name='move-{number}'])" for number in range(100, 130)]
    edit = f"XQUERY replace value of node doc('usual/{first.name}')//frame[1]/frame_bone[1]/@Rx with '1.5'"
    done = basex.run(
        [
            f"CREATE DB warm {folder / 'short' / 'mcml'}",
            "DROP DB warm",
            f"CREATE DB short {folder / 'short' / 'mcml'}",
            f"CREATE DB usual {folder / 'usual' / 'mcml'}",
            *counts,
            edit,
            *more,
        ]
    )
    result = {}
    for name in ("short", "usual"):
        ours = figures[name]
        loading = report(f"BaseX loads the {name} library as MCML, s", done.created[name] / 1e3)
        single, together = loading / ours["single_import_s"], loading / ours["import_s"]
        result[f"basex_load_ratio_{name}_single"] = report("  BaseX load / our import file by file", single, ">= 15")
        result[f"basex_load_ratio_{name}"] = report("  BaseX load / our import in one call", together, ">= 15")
        ratio = ours["bytes"] / done.bytes[name]
        result[f"basex_size_ratio_{name}"] = report("  our database with uploads / BaseX's", ratio, "<= 0.2")
    before, after = done.queries[: len(counts)], done.queries[-len(more) :]
    result["basex_count_ms"] = report("BaseX label count, ms", statistics.median(before))
    result["basex_count_after_edit_ms"] = report("  after an edit of one value, ms", statistics.median(after))
    return result


def _counts(client: httpx.Client, first: int) -> float:
    """Median milliseconds of label counts, each of a name not asked before, above those of `q=1`."""

    def asked(expression: str) -> float:
        start = time.perf_counter()
        client.get("/api/v1/xpath", params={"q": expression}).raise_for_status()
        return (time.perf_counter() - start) * 1e3

    counts, empty = [], []
    for number in range(first, first + ASKED):
        counts.append(asked(f"count(//frame[motion_name='move-{number}'])"))
        empty.append(asked("1"))
    return statistics.median(counts[5:]) - statistics.median(empty[5:])


def _edit(database: Database) -> float:
    times = []
    for number in range(9):
        with database.read() as tx:
            stored = max(tx.documents.page(DocumentFilter(), after=None, limit=1000), key=lambda item: item.frames)
        start = time.perf_counter()
        with database.write() as tx:
            where = f"/mcml/motion/frame[{100 + number}]/frame_bone[2]"
            change_element(tx, tx.documents.get(stored.uuid), where, Change({"Rx": f"{number}.5"}))
        times.append(time.perf_counter() - start)
    return statistics.median(times)
