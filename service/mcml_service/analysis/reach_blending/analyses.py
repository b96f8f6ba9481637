"""Reach blending as users see it: a fit that gives a model, and motions made with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mcml.motion.feet.locking import FootReport
from mcml_schemas.analyses.reach import (
    ReachClip,
    ReachClipChoice,
    ReachFoot,
    ReachMoment,
    ReachMotion,
    ReachMoves,
    ReachParameters,
    ReachPhases,
    ReachWarning,
    ReachWeight,
    ReachWish,
)
from mcml_schemas.revisions import FrameRange
from mcml_service.analysis.interface import (
    Analysis,
    AnalysisError,
    Answer,
    MadeClip,
    Motion,
    Part,
    PartInfo,
    Parts,
    Progress,
    ResultUse,
)
from mcml_service.analysis.reach_blending.fit import fit
from mcml_service.analysis.reach_blending.model import Model, Source
from mcml_service.analysis.reach_blending.options import Options, options_of
from mcml_service.analysis.reach_blending.parts import parts_of
from mcml_service.analysis.reach_blending.phases import angular_speed
from mcml_service.analysis.reach_blending.pictures import PICTURES
from mcml_service.analysis.reach_blending.stored import from_stored
from mcml_service.analysis.reach_blending.synthesis import Wish, synthesize


@dataclass(frozen=True)
class Ready:
    """A model ready to be used, the name of its phase joint, and the parts that tell of its clips."""

    model: Model
    phase_joint: str
    clips: Part
    speed: Part


def options_from(parameters: ReachParameters) -> Options:
    """Return the options for parameters; defaults depend on the method."""
    stated: dict[str, Any] = {
        name: getattr(parameters, name) for name in ReachParameters.model_fields if name not in ("method", "subject")
    }
    stated["attributes"] = tuple(dict.fromkeys(parameters.attributes))
    stated["scaling"] = stated.pop("attribute_space")
    stated["times"] = {name: (times.t1, times.t2, times.end) for name, times in parameters.times.items()}
    if parameters.knots is not None and not 0 < parameters.knots[0] < parameters.knots[1] < parameters.knots[2]:
        raise AnalysisError("knot-order", "The knots are not in order.", remedy="Give knots with 0 < t1 < t2 < end.")
    # None is a valid value here: people are not distinguished.
    return options_of(parameters.method, **stated, subject=parameters.subject or "")


def _check(parameters: ReachParameters, documents: Sequence[str]) -> None:
    options_from(parameters)
    for document, times in parameters.times.items():
        if document not in documents:
            raise AnalysisError(
                "unknown-clip",
                f"Times are given for {document!r}, which is not one of the documents.",
                remedy="Name documents of the selection.",
            )
        if not times.t1 < times.t2 < times.end:
            raise AnalysisError(
                "phase-order", f"The times of {document} are not in order.", remedy="Give times with 0 < t1 < t2 < end."
            )


def run(motions: Sequence[Motion], parameters: ReachParameters, progress: Progress) -> Parts:
    """The parts of a fitted model."""
    options = options_from(parameters)
    fitted = fit(motions, options, progress)
    progress("errors", 0.75)
    parts = parts_of(fitted, options)
    progress("done", 1.0)
    return parts


def prepare(parts: Parts) -> Ready:
    """The model of stored parts."""
    told = parts["model"]
    return Ready(
        from_stored(told.data["model"], told.arrays),
        told.data["summary"]["phase_joint"],
        parts["clips"],
        parts["speed"],
    )


def make(ready: Ready, wish: ReachWish) -> Answer:
    """A motion for attributes."""
    model = ready.model
    made = synthesize(model, Wish(**{name: getattr(wish, name) for name in ReachWish.model_fields}))
    hand = made.hand
    fps = 1.0 / made.clip.frame_time
    turned = made.clip.rotations[:, made.clip.skeleton.names.index(ready.phase_joint)]
    t1, t2, end = (ReachMoment(seconds=time, frames=time * fps) for time in made.times)
    answer = ReachMotion(
        attributes=wish.attributes,
        used_attributes=made.used,
        fps=fps,
        frames=len(made.clip.rotations),
        t1=t1,
        t2=t2,
        end=end,
        speed=angular_speed(turned, fps).round(4).tolist(),
        support=made.support,
        in_hull=made.in_hull,
        nn_ratio=made.nn_ratio,
        in_gaps=list(made.in_gaps),
        weights=[ReachWeight(clip=_clip(model.sources[place]), weight=weight) for place, weight in made.weights],
        skeleton_source=_clip(model.sources[made.template]),
        method=made.method,
        target=None if wish.target is None else list(wish.target),
        hand_place=None if hand is None else hand.place.tolist(),
        hand_error=None if hand is None else hand.error,
        hand_orientation=None if hand is None else hand.orientation.tolist(),
        orientation_error=None if hand is None else hand.turn_error,
        moved=None if hand is None or hand.moved is None else ReachMoves(**asdict(hand.moved)),
        feet=[_foot(made.clip, report, model.metres or 1.0) for report in made.feet],
        warnings=[ReachWarning(code=code, what=text) for code, text in made.warnings],
    )
    return Answer(answer, clip=made.clip)


def phases(ready: Ready, choice: ReachClipChoice) -> Answer:
    """The phases of a clip. Raises AnalysisError `unknown-clip`."""
    names = [column["name"] for column in ready.clips.data["columns"]]
    row = next((row for row in ready.clips.data["rows"] if row[0] == choice.document), None)
    if row is None:
        raise AnalysisError(
            "unknown-clip",
            f"The model was not given a document {choice.document!r}.",
            remedy="Name one of the documents that the part clips lists.",
        )
    about: Mapping[str, Any] = dict(zip(names, row, strict=True))
    place = list(ready.speed.data["documents"]).index(choice.document)
    first = np.asarray(ready.speed.arrays["first"])
    part = slice(int(first[place]), int(first[place + 1]))
    moments = [None if about[f"{name}_seconds"] is None else _moment(about, name) for name in ("t1", "t2", "end")]
    return Answer(
        ReachPhases(
            document=choice.document,
            name=about["name"],
            used=about["used"],
            reason=about["reason"],
            fps=about["fps"],
            speed=ready.speed.arrays["speed"][part].tolist(),
            components=ready.speed.arrays["components"][part].tolist(),
            t1=moments[0],
            t2=moments[1],
            end=moments[2],
            flags=about["flags"],
        )
    )


def _moment(about: Mapping[str, Any], name: str) -> ReachMoment:
    return ReachMoment(seconds=about[f"{name}_seconds"], frames=about[f"{name}_frames"])


def _foot(clip: MadeClip, report: FootReport, metres: float) -> ReachFoot:
    return ReachFoot(
        joint=clip.skeleton.joints[report.joint].name,
        contacts=[FrameRange(first=first + 1, last=last + 1) for first, last in report.contacts],
        slide_before=report.before * metres,
        slide=report.after * metres,
    )


def _clip(source: Source) -> ReachClip:
    return ReachClip(document=source.document, revision=source.revision, name=source.name, subject=source.subject)


REACH = Analysis(
    name="reach",
    title="Reach motion from attributes",
    description="A model that makes a reach for any age, height and hip point, or any other numbers that label clips.",
    parameters=ReachParameters,
    parts={
        "model": PartInfo("model", "The model with a summary: clips, phases, components, errors"),
        "clips": PartInfo("table", "Every clip: attributes, phases, or why it was left out"),
        "speed": PartInfo("curve", "Angular speed of the phase joint in every clip"),
        "variance": PartInfo("curve", "Share of the variance that the first eigenmotions hold"),
        "pose_variance": PartInfo("curve", "Share of the variance that the first eigenposes hold"),
        "errors": PartInfo("table", "Errors of the model, a linear model and the nearest example for clips left out"),
        "selection": PartInfo("table", "Widths and ridges that were tried"),
        "attributes": PartInfo("points", "Attributes of the clips and their coordinates"),
    },
    run=run,
    operations={
        "synthesize": ResultUse("Make a motion for attributes", ReachWish, ReachMotion, make),
        "phases": ResultUse("The phases of a clip and the speed behind them", ReachClipChoice, ReachPhases, phases),
    },
    prepare=prepare,
    check=_check,
    rules={"fit": "2 (clips with several fast movements)"},
    pictures=PICTURES,
    fewest=2,
    most=2000,
)
