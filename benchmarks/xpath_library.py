"""Three sizes of one library, each a store of its own; the larger hold all documents of the smaller."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.library import clips, labels, longer, write_plain
from mcml.files.import_options import ImportOptions, Label
from mcml.formats.format import SourceFile
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.edits import change_element

SIZES = (5, 25, 100)
TIMES = 5
"""How much longer than the files at hand the clips are: the usual library of the store's benchmark."""

ONLY = 45
"""Motion names that one document alone has: answers that are the same in each library."""

RARE = "1000000"
"""A rotation that one sample alone has, for the same reason."""


@dataclass(frozen=True)
class Size:
    """documents: uuid by number; a number is the place by name among all, the order in which all engines answer.
    mcml: a folder of the documents as files, named by their numbers."""

    url: str
    documents: dict[int, str]
    mcml: Path

    def file(self, number: int) -> Path:
        return self.mcml / f"{number:03}.xml"


@dataclass(frozen=True)
class Library:
    """one: number of the document that questions about one document ask. pairs: motion names that overlap."""

    what: str
    sizes: dict[int, Size]
    one: int
    pairs: list[tuple[str, str]]


def build(folder: Path) -> Library:
    what, files = clips()
    # Files of one source follow one another: take every twentieth, so that five are a fair sample.
    spread = sorted(range(len(files)), key=lambda place: (place % 20, place))
    lengthened = longer([files[place] for place in spread], TIMES)
    frames = [int(content.partition(b"Frames:")[2].split()[0]) for _, content in lengthened]
    one = int(np.argmax(frames[: SIZES[0]]))
    rng = np.random.default_rng(2)
    named = [labels(rng, count) for count in frames]
    named[one] += tuple(Label(f"only-{k}", 1 + 3 * k, 20 + 3 * k) for k in range(ONLY))
    stores = {}
    for size in SIZES:
        stores[size] = f"sqlite:///{folder / f'store{size}.db'}"
        _load(stores[size], lengthened[:size], named, one)
    sizes: dict[int, Size] = {}
    numbers: dict[str, int] = {}
    for size in sorted(SIZES, reverse=True):
        mcml = folder / f"u{size}"
        mcml.mkdir()
        database = Database(stores[size])
        documents = {}
        with database.read() as tx:
            for place, stored in enumerate(tx.documents.page(DocumentFilter(), after=None, limit=1000)):
                number = numbers.setdefault(stored.name, place)
                documents[number] = stored.uuid
                if size == max(SIZES):
                    write_plain(tx, stored, mcml / f"{number:03}.xml")
                else:
                    os.link(sizes[max(SIZES)].file(number), mcml / f"{number:03}.xml")
        database.close()
        if len(documents) != size:
            raise RuntimeError(f"{size} documents have {len(documents)} different names.")
        sizes[size] = Size(stores[size], dict(sorted(documents.items())), mcml)
    name = Path(lengthened[one][0]).stem
    text = sum(len(content) for _, content in lengthened)
    said = f"{what}, each followed by {TIMES - 1} variations of itself, {text / 1e6:.0f} MB, {sum(frames)} frames"
    return Library(said, {size: sizes[size] for size in SIZES}, numbers[name], _overlapping(named))


def _load(url: str, files: list[tuple[str, bytes]], named: list[tuple[Label, ...]], one: int) -> None:
    database = Database(url)
    database.migrate()
    for (name, content), given in zip(files, named, strict=False):
        done = import_files(database, [SourceFile(name, io.BytesIO(content))], ImportOptions(labels=given), Settings())
        if done.problems:
            raise done.problems[0][1]
    with database.write() as tx:
        stored = next(
            document
            for document in tx.documents.page(DocumentFilter(), after=None, limit=1000)
            if document.name == Path(files[one][0]).stem
        )
        change_element(tx, stored, "/mcml/motion/frame[3]/frame_bone[2]", Change({"Rz": RARE}))
    database.close()


def _overlapping(named: list[tuple[Label, ...]]) -> list[tuple[str, str]]:
    pairs = {
        (a.name, b.name)
        for given in named
        for a in given
        for b in given
        if a.name < b.name and not (a.name + b.name).count("only") and _meet(a, b)
    }
    return sorted(pairs)


def _meet(a: Label, b: Label) -> bool:
    return max(a.first or 1, b.first or 1) <= min(a.last or 1, b.last or 1)
