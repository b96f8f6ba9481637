"""The space of expressions as users see it: built by a job, walked through by operations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.markers import marker_skeleton
from mcml_schemas.analyses.expression import (
    ExpressionCandidate,
    ExpressionCandidateChoice,
    ExpressionFrame,
    ExpressionKey,
    ExpressionLevel,
    ExpressionLevelChoice,
    ExpressionLink,
    ExpressionNeighbour,
    ExpressionNeighbours,
    ExpressionParameters,
    ExpressionPoints,
    ExpressionStride,
    ExpressionTake,
    ExpressionWarning,
    Key,
)
from mcml_schemas.analyses.expression_paths import (
    ExpressionMotion,
    ExpressionOffer,
    ExpressionPath,
    ExpressionPathWish,
    ExpressionPlayback,
    ExpressionRefinement,
    ExpressionSample,
    ExpressionStep,
)
from mcml_service.analysis.expression_space.extension import extend
from mcml_service.analysis.expression_space.navigation import (
    Offer,
    accept_keys,
    check_links,
    link_keys,
    offers_near,
    offers_on_the_way,
    walk_over,
    with_picks,
)
from mcml_service.analysis.expression_space.options import Options, check_options, options_of
from mcml_service.analysis.expression_space.parts import parts_of
from mcml_service.analysis.expression_space.pictures import PICTURES
from mcml_service.analysis.expression_space.playback import markers_of, sample
from mcml_service.analysis.expression_space.space import build
from mcml_service.analysis.expression_space.stored import Path, Stored, from_stored, on_path, path_part
from mcml_service.analysis.interface import (
    Analysis,
    AnalysisError,
    Answer,
    MadeClip,
    Motion,
    PartInfo,
    Parts,
    Progress,
    ResultUse,
)

MILLIMETRE = 0.001


def options_from(parameters: ExpressionParameters) -> Options:
    """Return the options for parameters; defaults depend on the method."""
    stated = {
        name: getattr(parameters, name)
        for name in ExpressionParameters.model_fields
        if name not in ("method", "rho_mm", "markers")
    }
    return options_of(parameters.method, **stated, rho=parameters.rho_mm, markers=tuple(parameters.markers))


def run(motions: Sequence[Motion], parameters: ExpressionParameters, progress: Progress) -> Parts:
    """The parts of a new space."""
    space = build(motions, options_from(parameters), progress)
    parts = parts_of(space)
    progress("done", 1.0)
    return parts


def points(space: Stored, choice: ExpressionStride) -> Answer:
    """Return the places of every n-th frame on the map."""
    chosen = slice(None, None, choice.stride)
    plane = space.ground.plane[chosen]
    names = space.values["names"]
    return Answer(
        ExpressionPoints(
            total=len(space.take),
            stride=choice.stride,
            take=space.take[chosen].tolist(),
            frame=(space.frame[chosen] + 1).tolist(),
            x=plane[:, 0].tolist(),
            y=plane[:, 1].tolist(),
            takes=[
                ExpressionTake(document=document, name=name)
                for document, name in zip(space.documents, names, strict=True)
            ],
        )
    )


def level(space: Stored, choice: ExpressionLevelChoice) -> Answer:
    """Candidates of a level and the shortest links between them."""
    number = space.check_level(choice.level)
    candidates = space.ground.candidates[number]
    links = space.ground.links[number]
    graph = space.ground.graph
    first, second, length, bridge = (
        (graph.first, graph.second, graph.length, graph.bridge)
        if links is None
        else (links.first, links.second, links.length, links.bridge)
    )
    most = min(choice.most_links, len(first))
    shortest = np.argpartition(length, most - 1)[:most] if 0 < most < len(first) else np.arange(most)
    shortest = shortest[np.lexsort((second[shortest], first[shortest], length[shortest]))]
    about = space.levels[number]
    return Answer(
        ExpressionLevel(
            level=number,
            levels=len(space.ground.candidates),
            candidates=_candidates(space, number, range(len(candidates))),
            links=[
                ExpressionLink(a=a, b=b, length_mm=mm, bridge=over)
                for a, b, mm, over in zip(
                    first[shortest].tolist(),
                    second[shortest].tolist(),
                    length[shortest].tolist(),
                    bridge[shortest].tolist(),
                    strict=True,
                )
            ],
            links_total=len(first),
            components=space.components[number],
            unique=about["unique"],
            coverage_mm=about["coverage"],
        )
    )


def neighbours(space: Stored, choice: ExpressionCandidateChoice) -> Answer:
    """The candidates that are linked to one."""
    number = space.check_level(choice.level)
    frame = _find_frame(space, number, choice.key)
    place = _place_of(space, number, frame)
    links, graph = space.ground.links[number], space.ground.graph
    nearest: list[tuple[float, int, bool]]
    if links is None:
        matrix = graph.matrix
        row = slice(matrix.indptr[place], matrix.indptr[place + 1])
        nearest = [
            (mm, other, (min(place, other), max(place, other)) in graph.bridges)
            for other, mm in zip(matrix.indices[row].tolist(), matrix.data[row].tolist(), strict=True)
        ]
    else:
        nearest = []
        for own, others in ((links.first, links.second), (links.second, links.first)):
            at = np.flatnonzero(own == place)
            nearest += zip(links.length[at].tolist(), others[at].tolist(), links.bridge[at].tolist(), strict=True)
    nearest.sort()
    return Answer(
        ExpressionNeighbours(
            candidate=_candidates(space, number, [place])[0],
            neighbours=[
                ExpressionNeighbour(**dict(candidate), length_mm=mm, bridge=bool(over))
                for candidate, (mm, _, over) in zip(
                    _candidates(space, number, [other for _, other, _ in nearest]), nearest, strict=True
                )
            ],
        )
    )


def path(space: Stored, wish: ExpressionPathWish) -> Answer:
    """A new path over candidates of a level."""
    number = space.check_level(wish.level)
    keys = [_find_frame(space, number, key) for key in wish.keys]
    try:
        routed = link_keys(space.ground, number, keys, auto_route=wish.auto_route)
    except AnalysisError as error:
        raise _name_frames(space, error) from error
    made = Path(walk_over(space.ground, routed), number, 1)
    return Answer(_answer(space, made, [], set()), keep={"path": path_part(space, made)})


def refine(space: Stored, wish: ExpressionRefinement) -> Answer:
    """Return a refined version of the path of this result, or the options for one."""
    old = _path(space)
    number = space.check_level(wish.level)
    rule = wish.rule or space.values["method"]
    ground, walk = space.ground, old.walk
    picks = [_find_frame(space, number, key) for key in wish.keys]
    near = rule == "paper"
    offers = (
        offers_near(ground, walk, number, wish.radius_mm)
        if near
        else offers_on_the_way(ground, walk, number, wish.delta)
    )
    if not picks and not wish.auto:
        return Answer(_answer(space, old, offers, set()))
    try:
        keys = with_picks(ground, walk, number, picks) if picks else walk.keys.tolist()
        if near and picks:
            check_links(ground, number, keys)
    except AnalysisError as error:
        raise _name_frames(space, error) from error
    if wish.auto:
        base = walk_over(ground, keys)
        on_the_way = offers_on_the_way(ground, base, number, wish.delta)
        keys = accept_keys(ground, base, on_the_way, wish.delta)
    made = Path(walk_over(ground, keys), number, old.version + 1, old.warnings)
    return Answer(_answer(space, made, offers, set(keys)), keep={"path": path_part(space, made)})


def playback(space: Stored, wish: ExpressionPlayback) -> Answer:
    """The path of this result as a motion of markers."""
    walk = _path(space).walk
    speed = space.values["speed"] if wish.speed_mm_s is None else wish.speed_mm_s
    samples = sample(walk, speed, wish.fps, duration=wish.duration_s, loop=wish.loop)
    markers = markers_of(samples, space.positions, smooth=wish.smooth)
    missing = np.isnan(markers[..., 0])
    names = space.values["markers"]
    ends = [_frame(space, int(frame)) for frame in (walk.keys[0], walk.keys[-1])]
    clip = MadeClip(
        name="expression path",
        skeleton=marker_skeleton(names),
        frame_time=1.0 / wish.fps,
        rotations=np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (*markers.shape[:2], 4)),
        translations=np.where(missing[..., None], 0.0, markers),
        present=~missing if missing.any() else None,
        metres=MILLIMETRE,
        up=space.values["up"],
        description=f"A path over {len(walk.keys)} key frames, {walk.length:.0f} mm long, from frame {ends[0].frame} "
        f"of {ends[0].document} to frame {ends[1].frame} of {ends[1].document}, at {samples.speed:.0f} mm/s.",
    )
    shown = range(min(wish.most_samples, len(samples.alpha)))
    return Answer(
        ExpressionMotion(
            frames=len(markers),
            fps=wish.fps,
            duration_s=(len(markers) - 1) / wish.fps,
            speed_mm_s=samples.speed,
            length_mm=walk.length,
            samples=[
                ExpressionSample(
                    frame_a=_frame(space, int(samples.first[number])),
                    frame_b=_frame(space, int(samples.second[number])),
                    alpha=float(samples.alpha[number]),
                    position_mm=float(samples.position[number]),
                )
                for number in shown
            ],
            missing=int(missing.sum()),
        ),
        clip=clip,
    )


def _frame(space: Stored, number: int) -> ExpressionFrame:
    return ExpressionFrame(document=space.documents[space.take[number]], frame=int(space.frame[number]) + 1)


def _candidates(space: Stored, level: int, places: Sequence[int]) -> list[ExpressionCandidate]:
    chosen = np.asarray(places, dtype=np.intp)
    numbers = space.ground.candidates[level][chosen]
    columns = (space.take[numbers], space.frame[numbers] + 1, space.sizes[level][chosen])
    documents, plane = space.documents, space.ground.plane[numbers].tolist()
    return [
        ExpressionCandidate(document=documents[take], frame=frame, id=place, x=x, y=y, size=size)
        for place, take, frame, size, (x, y) in zip(places, *(c.tolist() for c in columns), plane, strict=True)
    ]


def _find_frame(space: Stored, level: int, key: Key) -> int:
    """The number of the frame that a candidate is. Raises AnalysisError `unknown-frame`, `not-a-candidate`."""
    if isinstance(key, ExpressionKey):
        return space.number(key.document, key.frame)
    candidates = space.ground.candidates[level]
    if key >= len(candidates):
        raise AnalysisError(
            "not-a-candidate",
            f"Level {level} has no candidate {key}.",
            remedy=f"Its ids are 0 to {len(candidates) - 1}; the operation `level` lists them.",
        )
    return int(candidates[key])


def _place_of(space: Stored, level: int, frame: int) -> int:
    places = np.flatnonzero(space.ground.candidates[level] == frame)
    if not len(places):
        where = _frame(space, frame)
        raise AnalysisError(
            "not-a-candidate",
            f"Frame {where.frame} of {where.document} is no candidate of level {level}.",
            remedy="Choose among the candidates that the operation `level` lists.",
        )
    return int(places[0])


def _path(space: Stored) -> Path:
    if space.path is None:
        raise AnalysisError(
            "no-path", "This result is a space, not a path.", remedy="Make one by the operation `path`."
        )
    return space.path


def _name_frames(space: Stored, error: AnalysisError) -> AnalysisError:
    """The error with frames as users name them."""
    told: dict[str, object] = {}
    what = error.what
    for name in ("frames", "suggestion"):
        if name in error.details:
            told[name] = [_frame(space, number).model_dump() for number in error.details[name]]
    if "frame" in error.details:
        where = _frame(space, error.details["frame"])
        told["frame"] = where.model_dump()
        what = what.replace(f"Frame {error.details['frame']} ", f"Frame {where.frame} of {where.document} ")
    return AnalysisError(error.code, what, remedy=error.remedy, **told)


def _answer(space: Stored, made: Path, offers: Sequence[Offer], taken: set[int]) -> ExpressionPath:
    walk = made.walk
    at = set(walk.at.tolist())
    warnings = list(made.warnings)
    if walk.bridges:
        warnings.append(("bridge-crossed", f"{walk.bridges} steps lead over edges that were added to join parts."))
    return ExpressionPath(
        version=made.version,
        level=made.level,
        keys=[_frame(space, int(key)) for key in walk.keys],
        walk=[
            ExpressionStep(**_frame(space, number).model_dump(), position_mm=position, key=place in at)
            for place, (number, position) in enumerate(zip(walk.frames.tolist(), walk.position.tolist(), strict=True))
        ],
        length_mm=walk.length,
        largest_hop_mm=walk.largest_hop,
        bridges=walk.bridges,
        offered=[
            ExpressionOffer(
                **_frame(space, offer.frame).model_dump(),
                segment=offer.segment,
                position_mm=offer.position,
                apart_mm=offer.apart,
                accepted=offer.frame in taken,
            )
            for offer in offers
        ],
        warnings=[ExpressionWarning(code=code, what=what) for code, what in warnings],
    )


EXPRESSION = Analysis(
    name="expression",
    title="The space of facial expressions",
    description="A map of all frames of facial takes with levels of detail, to find ways from face to face on.",
    parameters=ExpressionParameters,
    parts={
        "space": PartInfo("model", "The space with a summary: threshold, fit of the map, warnings"),
        "map": PartInfo("points", "Map position of every frame"),
        "levels": PartInfo("table", "Levels of detail: candidates, their coverage; memberships of all frames"),
        "links": PartInfo("graph", "Links between the candidates of each level"),
        "tau": PartInfo("curve", "Tested thresholds: correlation of map and geodesics, components, degree, stretch"),
        "fit": PartInfo("table", "Correlation and stress of the map in 2, 3, 5 and 10 dimensions"),
        "objective": PartInfo("curve", "Objective of fuzzy c-means after every iteration, level by level"),
        "takes": PartInfo("table", "Takes and how many of their frames are used"),
        "markers": PartInfo("table", "Markers used, and those left out with reasons"),
        "excluded": PartInfo("table", "Frames left out with reasons"),
        "path": PartInfo("table", "Of a path: the frames of its walk, and its keys"),
    },
    run=run,
    operations={
        "points": ResultUse("Places of frames on the map", ExpressionStride, ExpressionPoints, points),
        "level": ResultUse("Candidates and links of a level", ExpressionLevelChoice, ExpressionLevel, level),
        "neighbours": ResultUse(
            "Linked candidates of a candidate", ExpressionCandidateChoice, ExpressionNeighbours, neighbours
        ),
        "path": ResultUse("Make a path over key frames", ExpressionPathWish, ExpressionPath, path),
        "refine": ResultUse(
            "Refine a path, or list its possible refinements", ExpressionRefinement, ExpressionPath, refine
        ),
        "playback": ResultUse("Play a path as a motion of markers", ExpressionPlayback, ExpressionMotion, playback),
    },
    prepare=from_stored,
    proceed=on_path,
    extend=lambda parts, motions, _, progress: extend(parts, motions, progress),
    check=lambda parameters, _: check_options(options_from(parameters)),
    rules={"threshold": "2 (near faces near on the graph)"},
    pictures=PICTURES,
    fewest=1,
    most=2000,
)
