"""A repository and its documents, as Python sees them: the same operations as the API's and the command line's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from os import PathLike
from pathlib import Path, PurePath
from typing import Any, Literal

import numpy as np

from mcml.answers import Content
from mcml.client.arrays import ClipArrays
from mcml.client.choosing import choose_documents, find_document
from mcml.client.client import Client, JobProgress
from mcml.client.folders import Told, import_paths
from mcml.client.operations import Operations
from mcml.client.queries import Query
from mcml.errors import UnsupportedError
from mcml.files.convert_files import files_to_write, stated_format
from mcml.files.on_disk import write_file
from mcml.files.read_numbers import Space
from mcml.frames import Frames
from mcml_schemas.documents import DocumentDetail, DocumentSummary, FileProblem, Label
from mcml_schemas.jobs import Job
from mcml_schemas.measure import Measures
from mcml_schemas.skeletons import SkeletonView

_URLS = ("http://", "https://")

STORES = "mcml.stores"
"""The group of entry points that name what opens a store of this machine: (address) to a Client."""


def open(where: str | PathLike[str], token: str | None = None) -> Repository:
    """Open a repository: the address of a server (http://…), an SQLite file, or an SQLAlchemy URL of PostgreSQL.

    token: if the server needs one. A file that does not exist becomes an empty repository; ":memory:" exists until it
    is closed. Anybody who can open the file has all rights.
    """
    address = str(where)
    if address.startswith(_URLS):
        from mcml.client.remote import Remote

        return Repository(Remote(address, token))
    return Repository(_store(address))


def _store(address: str) -> Client:
    """A store of this machine, by the package that has one. UnsupportedError where none is installed."""
    for entry in entry_points(group=STORES):
        client: Client = entry.load()(address)
        return client
    raise UnsupportedError(
        f"{address} is a store, and nothing here opens one.",
        remedy="Install it: pip install 'mcml-repository[server]'.",
    )


@dataclass
class Imported:
    """The result of an import. documents: stored documents. problems: of files that were not stored."""

    documents: list[Document]
    problems: list[FileProblem]


class Repository:
    """Documents, and queries about them.

    As a context manager it is closed at the end. operations: all operations, by their names in the API description;
    answers are its models.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self.operations = Operations(client)

    def __enter__(self) -> Repository:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._client.close()

    def documents(self, text: str | None = None, **conditions: Any) -> list[Document]:
        """Documents by name. text: part of the name.

        conditions: project, motion_name, xpath (in which it finds something), format, property (["age:20..30"]),
        skeleton, deleted.
        """
        return [Document(self, item) for item in choose_documents(self._client, q=text, **conditions)]

    def document(self, text: str) -> Document:
        """Return the document with this id, beginning of an id, or name. Raises Error if there is none, or several."""
        return Document(self, find_document(self._client, text))

    def projects(self) -> list[str]:
        """Names of projects."""
        return list(self._client.call("list_projects").items)

    def xpath(
        self,
        expression: str,
        *,
        project: str | None = None,
        documents: list[str] | None = None,
        revision: int | None = None,
        per: Literal["document"] | None = None,
        guesses: Literal["yes", "no"] = "yes",
        **variables: str,
    ) -> Query:
        """A query; it runs when you read its result: `runs()`, `nodes()`, `value()`, `count()`, `to_pandas()`.

        documents: ids; default all. revision: of the single document. per: "document" queries each separately. guesses:
        "no" excludes documents whose unit, up axis or floor is guessed, in queries about bodies. variables: for $name
        in it.
        """
        asked: dict[str, Any] = {"project": project, "document": documents or [], "revision": revision, "per": per}
        asked |= {"guesses": guesses, "variables": variables}
        return Query(self._client, expression, asked)

    def measure(
        self,
        *quantities: str,
        documents: Sequence[Document | str] = (),
        project: str | None = None,
        query: str | None = None,
        cycles: str | Sequence[str] = (),
        by: Sequence[str] = ("side",),
        **options: Any,
    ) -> Measures:
        """Measure quantities such as "angle:left-knee-flexion" in frame ranges of many clips.

        documents: Documents, ids, or "collection:NAME". query: an XPath expression; its frame ranges are measured.
        cycles: labels whose occurrences are. Without both, clips as a whole, or with `strides=True` strides of gait.
        by: keys of groups (clip, label, side, person, project, property:NAME). options: strides, guesses ("no"), limit,
        and selection, a dictionary with other conditions. Ranges of the answer are outliers first, each with its curve
        of 101 values; its groups have mean curves; its warnings list missing clips with reasons.
        """
        request: dict[str, Any] = {
            "selection": self._select(documents, project, options.pop("selection", {})),
            "quantities": list(quantities),
            "query": query,
            "by": list(by),
        }
        request |= {"cycles": [cycles] if isinstance(cycles, str) else list(cycles), "curves": True, "limit": 10_000}
        measures: Measures = self._client.call("measure", request=request | options)
        return measures

    def arrays(
        self,
        *quantities: str,
        documents: Sequence[Document | str] = (),
        project: str | None = None,
        query: str | None = None,
        space: Space | None = None,
        bones: Sequence[str] = (),
        **options: Any,
    ) -> ClipArrays:
        """Return frames of many clips as one array: joint positions, or `quantities` such as "speed:right_hand".

        documents: Documents, ids, or "collection:NAME". query: an XPath expression, for the frame ranges in its answer.
        space: "positions", "rotations" or "channels"; with quantities "channels", of the stated bones. options: columns
        ("shared": those that all clips have), dtype ("f8"), guesses ("no"), and selection, a dictionary with other
        conditions.
        """
        request = {
            "selection": self._select(documents, project, options.pop("selection", {})),
            "query": query,
            "space": space or ("channels" if quantities else "positions"),
            "bones": list(bones),
            "quantities": list(quantities),
        }
        content = self._client.call("export_arrays", request=request | options)
        return ClipArrays.of(b"".join(map(bytes, content.blocks)), [notice.what for notice in content.notices])

    @staticmethod
    def _select(
        documents: Sequence[Document | str], project: str | None, others: Mapping[str, Any]
    ) -> dict[str, Any] | None:
        """A selection; None without conditions."""
        selection = dict(others)
        if documents:
            selection["documents"] = [item if isinstance(item, str) else item.id for item in documents]
        if project is not None:
            selection["project"] = project
        return selection or None

    def import_(self, *paths: str | PathLike[str], progress: Told | None = None, **options: Any) -> Imported:
        """Store files, folders with all their files, or zips.

        Existing clips are skipped. progress: called with (finished files, total, name of the file). options: project,
        name, description, label (["walk:1-20"]), property (["age=23 year"]), unit, up, frame_time, encoding, movements,
        on_duplicate ("new").
        """
        documents: list[Document] = []
        problems: list[FileProblem] = []
        for result in import_paths(self._client, [Path(path) for path in paths], options, progress):
            problems += result.problems
            documents += [self.document(item.id) for item in result.documents]
        return Imported(documents, problems)

    def finish(self, job: Job, progress: JobProgress | None = None) -> Job:
        """Wait for a job such as `operations.start_dance` returns: it is run here on a local store.

        progress: called with (stage, share from 0 to 1). An interruption cancels the job. Raises nothing if it fails:
        its `state` is "failed" then, and its `problem` has the reason.
        """
        return self._client.finish(job, progress or (lambda stage, share: None))


class Document:
    """A document at the time when it was read; `refresh` reads it again.

    Changes are revisions, which `undo` reverts.
    """

    def __init__(self, repository: Repository, summary: DocumentSummary) -> None:
        self._repository = repository
        self._summary = summary

    def __repr__(self) -> str:
        return f"<Document {self.name!r} {self.id}: {len(self)} frames, revision {self.revision}>"

    def __len__(self) -> int:
        """How many frames it has."""
        return self._summary.frames

    @property
    def id(self) -> str:
        return self._summary.id

    @property
    def name(self) -> str:
        return self._summary.name

    @property
    def project(self) -> str:
        return self._summary.project

    @property
    def format(self) -> str:
        return self._summary.format

    @property
    def frame_time(self) -> float | None:
        """Seconds of a frame, None if unknown."""
        return self._summary.seconds_per_frame

    @property
    def revision(self) -> int:
        return self._summary.revision

    def refresh(self) -> Document:
        """Return the current document."""
        self._summary = find_document(self._repository._client, self.id)
        return self

    def detail(self) -> DocumentDetail:
        """Its header, bones, properties, labels, files and receipt."""
        detail: DocumentDetail = self._call("get_document")
        return detail

    def skeleton(self) -> SkeletonView:
        """Its bones with parents, sides, offsets and channels; unit, up axis and rate, stated or likely."""
        view: SkeletonView = self._call("get_skeleton")
        return view

    def labels(self) -> list[Label]:
        """Motion names of its frames."""
        return list(self._repository._client.every("list_labels", id=self.id).items)

    def frames(
        self,
        *bones: str,
        space: Space = "channels",
        quantity: str | Sequence[str] = (),
        first: int = 1,
        last: int | None = None,
        step: int = 1,
    ) -> Frames:
        """Frames of frames first to last as an array: channels in the source's units, or positions or rotations.

        bones: MCML's names; default all. space: "channels" (frames, columns), "positions" (frames, bones, 3) or
        "rotations" (frames, bones, 4; x y z w), global, by forward kinematics. quantity: of the body, in metres,
        seconds and degrees, such as "height:left_hand" or "speed:right_hand,Root", as columns after those of bones;
        without bones alone. Their units are the `units` of the answer.
        """
        content = self._call(
            "get_frames",
            bone=list(bones) or None,
            space=space,
            quantity=([quantity] if isinstance(quantity, str) else list(quantity)) or None,
            first=first,
            last=last,
            step=step,
            format="npz",
        )
        return _numbers(content)

    def export(
        self, path: str | PathLike[str], *, format: str | None = None, force: bool = False, **options: Any
    ) -> Path:
        """Export it to a file; return the path.

        format: if the name does not decide it. force: replace an existing file.

        options: first, last, names (of joints: mcml, bvh1, bvh2, asf, htr), unit, up, frame_time, revision, original,
        for_: a program such as "blender", which decides unit and axes, and format and ending of a name without one. A
        name that ends with .asf or .amc makes both files.
        """
        target = Path(path)
        chosen = stated_format(target, format, options.get("for_"))
        for part, form in files_to_write(target, chosen) if chosen else [(target, None)]:
            content = self._call("export_document", format=form, **options)
            if form is None:
                target = part = target.with_suffix(PurePath(content.name or "").suffix)
            write_file(part, content.blocks, force=force)
        return target

    def rename(self, name: str, message: str = "") -> Document:
        """Give it another name."""
        return self._change(name=name, message=message)

    def move(self, project: str, message: str = "") -> Document:
        """Move it to a project, which is made if it is new."""
        return self._change(project=project, message=message)

    def set(self, message: str = "", **facts: Any) -> Document:
        """Set values that its file does not state: unit, up, description, frame_time (a number, or a text such as
        "1/120").

        Nothing is converted.
        """
        return self._change(**facts, message=message)

    def label(self, name: str, first: int = 1, last: int | None = None) -> Document:
        """Name frames first to last."""
        asked = {"name": name, "first": first, "last": len(self) if last is None else last}
        self._call("add_labels", labels=[asked], if_match="*")
        return self.refresh()

    def undo(self) -> Document:
        """Take back its last revision."""
        self._call("undo_revision", if_match=f'"{self.refresh().revision}"')
        return self.refresh()

    def delete(self) -> None:
        """Hide it; the operation restore_document brings it back."""
        self._call("delete_document", if_match="*")

    def _change(self, **change: Any) -> Document:
        self._call("change_document", change=change, if_match="*")
        return self.refresh()

    def _call(self, name: str, **given: Any) -> Any:
        return self._repository._client.call(name, id=self.id, **given)


def _numbers(content: Content) -> Frames:
    import io

    array = np.load(io.BytesIO(b"".join(map(bytes, content.blocks))))
    units = array["units"].tolist() if "units" in array else []
    return Frames.of(array["values"], array["columns"].tolist(), array["times"], array["ids"].tolist(), units)
