"""Loading, sizes, label counts and edits: SQLite store against BaseX (text and attribute index on), lxml, simdjson."""

from __future__ import annotations

import re
import statistics
import tempfile
import time
from pathlib import Path

import httpx
import simdjson
from lxml import etree

from benchmarks import basex
from benchmarks.library import clips, load, served
from benchmarks.timing import median_seconds, report
from service.actions.edit_element import Change, change_element
from service.actions.export_motion import ExportOptions, export_document
from service.actions.read_clip import read_clip
from service.mcml.writer import write_document
from service.storage.database import Database, Transaction
from service.storage.documents import DocumentFilter, StoredDocument

ASKED = 120
"""Label counts timed; each with a constant not asked before."""


def run() -> dict[str, object]:
    what, files = clips()
    text = sum(len(content) for _, content in files)
    print(f"   {len(files)} {what}, {text / 1e6:.1f} MB")
    figures: dict[str, object] = {"what": what, "bytes": text}
    with tempfile.TemporaryDirectory() as folder:
        figures |= _measure(Path(folder), files, text)
    return figures


def _measure(folder: Path, files: list[tuple[str, bytes]], text: int) -> dict[str, float]:
    figures: dict[str, float] = {}
    parse = _bare_parse(files)
    best = 1e9
    for attempt in range(3):
        timed = Database(f"sqlite:///{folder / f'timed{attempt}.db'}")
        timed.migrate()
        best = min(best, load(timed, files, labelled=False))
        timed.close()
    figures["import_s"] = report("import of all, upload kept, s (best of 3)", best)
    figures["import_to_parse"] = report("import / bare simdjson parse", best / parse, "<= 12 for one large file, below")
    url = f"sqlite:///{folder / 'store.db'}"
    database = Database(url)
    database.migrate()
    load(database, files, labelled=True)
    sizes = database.size()
    figures["size_without_uploads"] = report(
        "database without kept uploads / BVH text", (sizes["total"] - sizes["uploads"]) / text, "<= 0.30"
    )
    figures["size_with_uploads"] = report("database with kept uploads / BVH text", sizes["total"] / text, "<= 0.62")
    mcml = folder / "mcml"
    mcml.mkdir()
    with database.read() as tx:
        stored = tx.documents.page(DocumentFilter(), after=None, limit=1000)
        for document in stored:
            _write_plain(tx, document, mcml / f"{document.uuid}.xml")
    figures |= _writing(database)
    figures |= _large_file(folder, files)
    names = [f"move-{number}" for number in range(200)]
    if basex.available():
        figures |= _against_basex(mcml, names, best, sizes)
    else:
        print("   BaseX is not installed (Debian package basex): its ratios are left out")
    with served(url) as client:
        figures["label_count_above_empty_ms"] = report(
            "label count over HTTP, ms above the same route asked q=1", _counts(client, names, "a"), "<= 1"
        )
        figures["edit_ms"] = report("one value of one frame_bone edited, ms", _edit(database) * 1e3)
        figures["label_count_above_empty_after_edit_ms"] = report(
            "the same after an edit", _counts(client, names, "b"), "<= 1; BaseX after an edit: above"
        )
    database.close()
    return figures


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
    """One large clip: the biggest file's motion repeated to about 50 MB."""
    name, content = max(files, key=lambda item: len(item[1]))
    head, middle, body = re.split(rb"(Frames:\s*\d+\s+Frame Time:\s*\S+[ \t\r]*\n)", content, maxsplit=1)
    frames = int(middle.split()[1])
    times = max(1, 50_000_000 // len(body))
    big = head + middle.replace(str(frames).encode(), str(frames * times).encode(), 1)
    big += (body.rstrip() + b"\n") * times
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
            _write_plain(tx, stored, target / "large.xml")
        done = basex.run([f"CREATE DB one {target}"])
        loading = report("BaseX loads its MCML, s", done.created["one"] / 1e3)
        figures["large_basex_load_ratio"] = report("BaseX load / our import of it", loading / best, ">= 15")
    database.close()
    return figures


def _write_plain(tx: Transaction, stored: StoredDocument, path: Path) -> None:
    """The document as MCML without its DOCTYPE: BaseX shall load, not validate."""
    with path.open("wb") as target:
        for number, block in enumerate(export_document(tx, stored, ExportOptions("mcml")).content):
            target.write(re.sub(rb"<!DOCTYPE[^>]*>\n", b"", block) if number < 4 else block)


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


def _against_basex(mcml: Path, names: list[str], ours: float, sizes: dict[str, int]) -> dict[str, float]:
    first = next(iter(sorted(mcml.glob("*.xml"))))
    counts = [f"XQUERY count(//frame[motion_name='{name}'])" for name in names[:30]]
    edit = f"XQUERY replace value of node doc('two/{first.name}')//frame[1]/frame_bone[1]/@Rx with '1.5'"
    done = basex.run(
        [f"CREATE DB one {mcml}", "DROP DB one", f"CREATE DB two {mcml}", *counts, edit, *counts],
    )
    loading = done.created["two"] / 1e3
    before = statistics.median(done.queries[: len(counts)])
    after = statistics.median(done.queries[-len(counts) :])
    report("BaseX loads the same as MCML, s (second load in a warm JVM)", loading)
    report("BaseX label count, ms, before and", before)
    report("after an edit of one value", after)
    total = sizes["total"]
    return {
        "basex_load_ratio": report("BaseX load / our import", loading / ours, ">= 15"),
        "basex_size_ratio": report("our database with uploads / BaseX's", total / done.bytes["two"], "<= 0.2"),
        "basex_count_ms": before,
        "basex_count_after_edit_ms": after,
    }


def _counts(client: httpx.Client, names: list[str], salt: str) -> float:
    """Median milliseconds of label counts with fresh constants, above those of `q=1`."""

    def asked(expression: str) -> float:
        start = time.perf_counter()
        client.get("/api/v1/xpath", params={"q": expression}).raise_for_status()
        return (time.perf_counter() - start) * 1e3

    counts, empty = [], []
    for number in range(ASKED):
        name = names[number] if salt == "a" else names[-1 - number % len(names)]
        counts.append(asked(f"count(//frame[motion_name='{name}'])"))
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
