"""Runs the benchmarks that are named, or all; prints and keeps the figures in benchmarks/results/."""

from __future__ import annotations

import importlib
import json
import platform
import sys
import time
from pathlib import Path

BENCHMARKS = {
    "beside": "a library of thousands of clips, beside BaseX",
    "cluster": "a graph of 2,000 bars by one and by two workers, of this host and of Dask",
    "bodies": "bodies of a library: deriving, room, questions beside channels, what is most alike",
    "dance": "beats of an hour, a graph of 500 bars, three minutes of dance",
    "edits": "one value, difference, undo, label, cut in a document of 100,000 frames",
    "expression": "expression spaces: all stages, operations, 96,000 frames",
    "formats": "reading and writing BVH, against pybvh, simdjson, numpy.savetxt",
    "hostile": "a reader beside clients whose expressions are made to take all time and memory",
    "imports": "imports of thousands of short clips: in one call, file by file, over HTTP",
    "load": "a hundred people read and ten write for ten minutes",
    "layouts": "ways to lay frames out in SQLite, against each other",
    "library": "libraries of thousands of clips, over HTTP",
    "lists": "lists of 100,000 documents: pages, searches, orders, facets, the feed",
    "panels": "windows of the analyses in the browser: a map of 100,000 faces",
    "reach": "reach models: fit, synthesis, memory, growth",
    "readers": "readers on inputs that double, with gaps, warnings, repairs and faults",
    "share": "generated XPath expressions answered without projection",
    "store": "loading, sizes, label counts, edits, against BaseX and lxml",
    "studio": "the studio in a browser: start, frames, memory, 30,000 clips",
    "xpath": "questions on three sizes of library, against BaseX, lxml, PostgreSQL's xpath()",
}


def main(names: list[str]) -> None:
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        sys.exit(f"unknown benchmark {unknown[0]!r}; there are: {', '.join(BENCHMARKS)}")
    folder = Path(__file__).parent / "results"
    folder.mkdir(exist_ok=True)
    figures: dict[str, object] = {"machine": platform.platform(), "python": platform.python_version()}
    for name in names or list(BENCHMARKS):
        print(f"== {name}: {BENCHMARKS[name]}", flush=True)
        figures[name] = importlib.import_module(f"benchmarks.bench_{name}").run()
    target = folder / f"{time.strftime('%Y%m%d-%H%M%S')}.json"
    target.write_text(json.dumps(figures, indent=2))
    print(f"kept in {target}; compare two with `python -m benchmarks.compare A B`")


if __name__ == "__main__":
    main(sys.argv[1:])
