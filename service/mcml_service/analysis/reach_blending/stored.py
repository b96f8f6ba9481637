"""A model as arrays and plain values, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Convention, EndSite, Joint, Skeleton
from mcml.motion.solving.joint_ranges import JointRanges
from mcml_service.analysis.reach_blending.attribute_space import AttributeSpace
from mcml_service.analysis.reach_blending.blend import Blend
from mcml_service.analysis.reach_blending.model import Model, Reaching, Source, cardinal_of
from mcml_service.analysis.reach_blending.motion_spaces import (
    EigenposeSpace,
    GlobalPoseSpace,
    MotionSpace,
    TangentSpace,
)

Arrays = Mapping[str, NDArray[Any]]


def to_arrays(model: Model) -> dict[str, NDArray[Any]]:
    """All numbers of a model, by name."""
    arrays: dict[str, NDArray[Any]] = {
        "offsets": model.offsets,
        "tips": model.tips,
        "attributes": model.attributes,
        "attribute_mean": model.attribute_space.mean,
        "attribute_scale": model.attribute_space.scale,
        "attribute_matrix": model.attribute_space.matrix,
        "example_of": model.example_of.astype(np.int64),
        "mean": model.mean,
        "basis": model.basis,
        "centres": model.coefficients.centres,
        "radial": model.coefficients.radial,
        "polynomial": model.coefficients.polynomial,
        "time_radial": model.times.radial,
        "time_polynomial": model.times.polynomial,
    }
    space = model.motion_space
    if isinstance(space, TangentSpace):
        arrays["reference"] = space.reference
    elif isinstance(space, GlobalPoseSpace):
        arrays |= {"pose_mean": space.mean, "pose_basis": space.basis}
    if model.reaching is not None:
        ranges = model.reaching.ranges
        arrays |= {
            "range_reference": ranges.reference,
            "range_axes": ranges.axes,
            "range_low": ranges.low,
            "range_high": ranges.high,
        }
        if model.reaching.hinge is not None:
            arrays["hinge"] = model.reaching.hinge
    if model.contacts is not None:
        arrays["contacts"] = model.contacts
    return arrays


def to_values(model: Model) -> dict[str, Any]:
    """All of a model that is no array, as JSON has it."""
    space = model.motion_space
    kind: dict[str, Any] = {"name": "global"}
    if isinstance(space, TangentSpace):
        kind = {"name": "tangent", "length": space.length}
    elif isinstance(space, EigenposeSpace):
        kind = {"name": "eigenposes", "joints": space.joints, "count": space.count}
    return {
        "joints": [asdict(joint) for joint in model.skeleton.joints],
        "metres": model.metres,
        "up": model.up,
        "sources": [asdict(source) for source in model.sources],
        "attribute_names": list(model.names),
        "attribute_units": list(model.units),
        "dropped": model.attribute_space.dropped,
        "gaps": [[list(gap) for gap in gaps] for gaps in model.gaps],
        "neighbour": model.neighbour,
        "space": kind,
        "s": model.coefficients.s,
        "lam": model.coefficients.lam,
        "time_s": model.times.s,
        "time_lam": model.times.lam,
        "degree": model.coefficients.degree,
        "knots": list(model.knots),
        "base_fps": model.base_fps,
        "log_times": model.log_times,
        "legacy_time_map": model.legacy_time_map,
        "reaching": _reaching_values(model.reaching),
    }


def from_stored(values: Mapping[str, Any], arrays: Arrays) -> Model:
    """The model that gave these values and arrays; nothing is fitted again."""
    centres, degree = np.asarray(arrays["centres"]), int(values["degree"])
    coefficients = Blend(
        centres, values["s"], values["lam"], np.asarray(arrays["radial"]), np.asarray(arrays["polynomial"]), degree
    )
    c1, c2, end = values["knots"]
    return Model(
        skeleton=Skeleton(tuple(_joint(joint) for joint in values["joints"])),
        offsets=np.asarray(arrays["offsets"]),
        tips=np.asarray(arrays["tips"]),
        metres=values["metres"],
        up=values["up"],
        sources=tuple(Source(**source) for source in values["sources"]),
        names=tuple(values["attribute_names"]),
        units=tuple(values["attribute_units"]),
        attributes=np.asarray(arrays["attributes"]),
        attribute_space=AttributeSpace(
            np.asarray(arrays["attribute_mean"]),
            np.asarray(arrays["attribute_scale"]),
            np.asarray(arrays["attribute_matrix"]),
            int(values["dropped"]),
        ),
        example_of=np.asarray(arrays["example_of"], dtype=np.intp),
        gaps=tuple(tuple((low, high) for low, high in gaps) for gaps in values["gaps"]),
        neighbour=values["neighbour"],
        motion_space=_space(values["space"], arrays),
        mean=np.asarray(arrays["mean"]),
        basis=np.asarray(arrays["basis"]),
        coefficients=coefficients,
        times=Blend(
            centres,
            values["time_s"],
            values["time_lam"],
            np.asarray(arrays["time_radial"]),
            np.asarray(arrays["time_polynomial"]),
            degree,
        ),
        cardinal=cardinal_of(coefficients),
        knots=(c1, c2, end),
        base_fps=values["base_fps"],
        log_times=values["log_times"],
        legacy_time_map=values["legacy_time_map"],
        reaching=_reaching(values.get("reaching"), arrays),
        contacts=np.asarray(arrays["contacts"]) if "contacts" in arrays else None,
    )


def _space(kind: Mapping[str, Any], arrays: Arrays) -> MotionSpace:
    if kind["name"] == "tangent":
        return TangentSpace(np.asarray(arrays["reference"]), kind["length"])
    if kind["name"] == "eigenposes":
        return EigenposeSpace(kind["joints"], kind["count"])
    return GlobalPoseSpace(np.asarray(arrays["pose_mean"]), np.asarray(arrays["pose_basis"]))


def _reaching_values(reaching: Reaching | None) -> dict[str, Any] | None:
    if reaching is None:
        return None
    return {
        "chain": list(reaching.chain),
        "shoulder": reaching.shoulder,
        "elbow": reaching.elbow,
        "hold": reaching.hold,
    }


def _reaching(values: Mapping[str, Any] | None, arrays: Arrays) -> Reaching | None:
    """The arm of a stored model; models of earlier releases have none."""
    if values is None:
        return None
    ranges = (np.asarray(arrays[f"range_{name}"]) for name in ("reference", "axes", "low", "high"))
    return Reaching(
        chain=tuple(values["chain"]),
        shoulder=values["shoulder"],
        elbow=values["elbow"],
        hinge=np.asarray(arrays["hinge"]) if "hinge" in arrays else None,
        ranges=JointRanges(*ranges),
        hold=values["hold"],
    )


def _joint(values: Mapping[str, Any]) -> Joint:
    """A joint of JSON, whose tuples have become lists."""
    sites = tuple(EndSite(_tuple(site["offset"]), site["name"], site["before"]) for site in values["end_sites"])
    plain = {name: _tuple(value) for name, value in values.items() if name not in ("convention", "end_sites")}
    return Joint(convention=Convention(values["convention"]), end_sites=sites, **plain)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
