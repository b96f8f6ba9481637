"""The interface of analyses: motions in, parts of a result out.

Independent of HTTP and SQL. Frames are 0-based in arrays; answers to users add one. Quaternions are x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from numpy.typing import NDArray
from pydantic import BaseModel

from mcml.errors import McmlError
from mcml.laboratory.gait_trials import Trial
from mcml.laboratory.measure_gait import EventSource
from mcml.motion.hub import walked
from mcml.motion.skeleton import Array, Skeleton

Kind = Literal["clip", "curve", "points", "graph", "table", "model"]


class AnalysisError(McmlError):
    """Clips or parameters that an analysis cannot use.

    code: the name of the error in the specification of the analysis, such as "too-few-examples"; part of the answer.
    """

    def __init__(self, code: str, what: str, *, remedy: str | None = None, **details: Any) -> None:
        super().__init__(what, remedy=remedy, code=code, **details)
        self.code = code


class Progress(Protocol):
    """Called regularly with the progress of the work: a word for the stage and the finished share of the whole, 0 to 1.

    Raises an error if the user has cancelled the work; an analysis does not catch it.
    """

    def __call__(self, stage: str, share: float) -> None: ...


def silent(stage: str, share: float) -> None:
    """Ignore progress."""


@dataclass(frozen=True)
class Motion:
    """A stored clip at one revision, as analyses see it.

    skeleton: joints of convention LISTED (clips of other conventions are converted), or MARKER for labelled points.
    frame_time: seconds. rotations: (F, J, 4) local, the identity is the rest pose. translations: (F, J, 3) from the
    parent in its axes (a root's and a marker's: in the world), in the clip's unit. present: (F, J), False where the
    source has no sample (the arrays hold the last value there); None: all are present.
    metres: of the clip's unit of length, None if unknown. up: "X", "Y" or "Z" if stated.
    properties: name -> (text, unit). labels: (motion name, first, last), frames 0-based, both included.
    """

    document: str
    revision: int
    name: str
    skeleton: Skeleton
    frame_time: float
    rotations: Array
    translations: Array
    present: NDArray[Any] | None = None
    metres: float | None = None
    up: str | None = None
    properties: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    labels: tuple[tuple[str, int, int], ...] = ()

    def __len__(self) -> int:
        return len(self.rotations)

    @property
    def fps(self) -> float:
        return 1.0 / self.frame_time

    def walk(self) -> tuple[Array, Array]:
        """Positions (F, J, 3) and rotations (F, J, 4) of all joints in the world."""
        return walked(self.skeleton, self.translations, self.rotations)


class TrialSource(Protocol):
    """A stored clip at one revision, of which an analysis measures the gait alone. It is read when it is measured.

    properties: name -> (text, unit).
    """

    @property
    def properties(self) -> Mapping[str, tuple[str, str]]: ...

    def measure(self, source: EventSource) -> Trial:
        """Measure the gait, without cycles; a clip without gait has the reason among its warnings."""
        ...


@dataclass(frozen=True)
class MadeClip:
    """A motion that an analysis made, to be stored as a document or exported.

    Fields as in `Motion`. description: one sentence for people. labels: (motion name, first, last), 0-based.
    properties: (name, text, unit).
    """

    name: str
    skeleton: Skeleton
    frame_time: float
    rotations: Array
    translations: Array
    present: NDArray[Any] | None = None
    metres: float | None = None
    up: str | None = None
    description: str = ""
    properties: tuple[tuple[str, str, str], ...] = ()
    labels: tuple[tuple[str, int, int], ...] = ()


@dataclass(frozen=True)
class Part:
    """One part of a result.

    kind: its presentation. data: plain JSON values, for people and programs; small. arrays: large data, by name; a
    client gets each as JSON or npy, operations get them unchanged. clip: for kind "clip".
    """

    kind: Kind
    data: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    clip: MadeClip | None = None


Parts = Mapping[str, Part]


@dataclass(frozen=True)
class Answer:
    """The output of an operation on a result: a value, optionally a clip, and optionally parts to store as a
    separate result, which then also has the operations of the same analysis.
    """

    value: BaseModel
    clip: MadeClip | None = None
    keep: Parts | None = None


@dataclass(frozen=True)
class PartInfo:
    """A part that results have, for the catalogue."""

    kind: Kind
    description: str


@dataclass(frozen=True)
class ResultUse:
    """A fast operation on a finished result (milliseconds), such as synthesising a motion with a fitted model.

    parameters, answer: models of input and output. run: (the output of `Analysis.prepare` for the result's parts,
    parameters) -> Answer; pure. Raises AnalysisError.
    """

    description: str
    parameters: type[BaseModel]
    answer: type[BaseModel]
    run: Callable[[Any, Any], Answer]


@dataclass(frozen=True)
class Picture:
    """A picture of a finished result, for a page or a paper.

    parts: the drawn parts; missing parts are left out, and without the first there is no picture.
    draw: (parts, an empty figure of matplotlib) fills the figure. inches: width and height.
    """

    description: str
    parts: tuple[str, ...]
    draw: Callable[[Parts, Any], None]
    inches: tuple[float, float] = (7.0, 4.5)


@dataclass(frozen=True)
class Analysis:
    """An entry of the catalogue.

    name: in addresses and on the command line. title, description: for people. parameters: the model whose fields,
    limits and descriptions make the API's documentation and forms. fewest, most: limits of the number of clips.
    parts: by name, those a result may have. operations: by name.
    reads: "motions", or "trials" for an analysis of gait, whose trials are read one by one.
    run: (motions or trials sorted by document id, parameters, progress) -> parts. Raises AnalysisError. Deterministic.
    prepare: (parts of a stored result) -> the first argument of its operations, cached between calls. proceed: (the
    prepared result, the parts that an operation on it stored) -> the prepared result of those; shares common data.
    extend: (parts of a stored result, motions to add, parameters, progress) -> parts of a new one; None if a result
    cannot be extended. check: (parameters, ids of the documents) raises AnalysisError for obvious errors, before there
    is a job.
    rules: the versions of its rules, by name, which results record: a rule whose results change gets a new one.
    spreads: whether it splits its work with `pieces.each` and `pieces.spread_of`, so that several workers can share it.
    pictures: by name, the first is the default. Without pictures, each part is drawn by its kind.
    """

    name: str
    title: str
    description: str
    parameters: type[BaseModel]
    parts: Mapping[str, PartInfo]
    run: Callable[[Sequence[Any], Any, Progress], Parts]
    reads: Literal["motions", "trials"] = "motions"
    operations: Mapping[str, ResultUse] = field(default_factory=dict)
    prepare: Callable[[Parts], Any] = lambda parts: parts
    proceed: Callable[[Any, Parts], Any] = lambda ready, parts: ready
    extend: Callable[[Parts, Sequence[Any], Any, Progress], Parts] | None = None
    check: Callable[[Any, Sequence[str]], None] = lambda parameters, documents: None
    rules: Mapping[str, str] = field(default_factory=dict)
    spreads: bool = False
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    fewest: int = 1
    most: int = 2000
