"""Options of a fit, all explicit; the two methods are two sets of values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from mcml_service.analysis.reach_blending.attribute_space import Scaling
from mcml_service.analysis.reach_blending.motion_spaces import SignAlign
from mcml_service.analysis.reach_blending.phases import Method
from mcml_service.analysis.reach_blending.time_normalisation import PAPER_KNOTS, Knots

Space = Literal["eigenposes", "tangent", "global"]
Duplicates = Literal["error", "mean", "keep"]


@dataclass(frozen=True)
class Options:
    """Options for fitting a model.

    attributes: names of the clips' properties. subject: name of the property that identifies people, None: none.
    phase_joint: the joint whose speed decides the phases. hand_joint: the joint whose position is compared; None: the
    hand below phase_joint. times: (t1, t2, end) by document, in frames since the first, set by a person. knots: None:
    rounded means. components: K at most; variance: instead, the share that K must explain. s, lam: None: by
    cross-validation; choose_by: which error of left-out clips decides then. duplicates: of attributes; None: averaged
    where lam is 0, else kept. log_times: times as logarithms of durations. align: "start" moves clips on the ground,
    and turns them about the vertical, so that the root of each is above the origin and faces as in the rest pose when
    the reach begins.
    """

    method: Method = "robust"
    attributes: tuple[str, ...] = ("age", "height", "hbp")
    subject: str | None = "subject"
    phase_joint: str = "right_up_arm"
    hand_joint: str | None = None
    phase_method: Method = "robust"
    times: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    on_bad_clip: Literal["exclude", "error"] = "exclude"
    joints: Literal["same", "intersection"] = "same"
    base_fps: float = 30.0
    knots: Knots | None = None
    space: Space = "tangent"
    pose_components: int = 10
    components: int = 10
    variance: float | None = None
    sign_align: SignAlign = "max"
    scaling: Scaling = "whiten"
    s: float | None = None
    lam: float | None = None
    choose_by: Literal["coefficients", "hand"] = "coefficients"
    degree: int = 1
    interpolate: bool = False
    duplicates: Duplicates | None = None
    log_times: bool = True
    legacy_time_map: bool = False
    align: Literal["none", "start"] = "none"
    force: bool = False


_PAPER: Mapping[str, Any] = {
    "phase_method": "paper",
    "knots": PAPER_KNOTS,
    "space": "eigenposes",
    "scaling": "rotate",
    "lam": 0.0,
    "duplicates": "error",
    "log_times": False,
}


def options_of(method: Method = "robust", **stated: Any) -> Options:
    """The options of a method, with those that are stated (None: not stated)."""
    values = {name: value for name, value in stated.items() if value is not None}
    return Options(method=method, **{**(_PAPER if method == "paper" else {}), **values})
