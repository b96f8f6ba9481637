"""Three analyses for users: beats and bars, the graph of bars, a new dance. Specification: docs/analyses/dance.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from mcml.motion.skeleton import Array
from mcml_schemas.analyses.dance import (
    BeatsParameters,
    DanceParameters,
    EdgesWish,
    GraphEdge,
    GraphEdges,
    GraphParameters,
    StageSize,
)
from mcml_service.analysis.dance import tables
from mcml_service.analysis.dance.assembly import Dance, cut_dance, lock_feet_of
from mcml_service.analysis.dance.bar_graph import BarGraph, bar_graph
from mcml_service.analysis.dance.blend import Blend
from mcml_service.analysis.dance.choreography import (
    MOST_OUT,
    Choice,
    Plan,
    Wish,
    check_pulse,
    dance_of,
    turn_dance,
)
from mcml_service.analysis.dance.energy import Loudness, check_loudness
from mcml_service.analysis.dance.group_dance.dancers import Group, bars_of_each, make_dancers
from mcml_service.analysis.dance.group_dance.figures import measure_group
from mcml_service.analysis.dance.made_clip import Naming, make_clip
from mcml_service.analysis.dance.measured import measure
from mcml_service.analysis.dance.motion_graph import strong_components
from mcml_service.analysis.dance.music import check_bpm, music_grid
from mcml_service.analysis.dance.pictures import BEATS_PICTURES, DANCE_PICTURES, GRAPH_PICTURES
from mcml_service.analysis.dance.sources import Clip, Search, channels_of, on_one_skeleton, read_clip, upright_clip
from mcml_service.analysis.dance.stage import Stage
from mcml_service.analysis.dance.tempo import Tempo, tempo_of
from mcml_service.analysis.dance.time_warp import even_grid, frame_count, motion_grid
from mcml_service.analysis.interface import (
    Analysis,
    AnalysisError,
    Answer,
    Motion,
    Part,
    PartInfo,
    Parts,
    Progress,
    ResultUse,
)
from mcml_service.analysis.pieces import each, spread_of


def _search(parameters: BeatsParameters, document: str) -> Search:
    """Return the search options of one clip: the parameters, with corrections for the clip."""
    search = Search(
        smooth=parameters.smooth,
        difference=parameters.difference,
        k2=parameters.k2,
        k3=parameters.k3,
        locate=parameters.locate,
        source_bpm=parameters.source_bpm,
        beats=parameters.beats_from,
        interval_tolerance=parameters.interval_tolerance,
        stride=parameters.stride,
        lead_in=parameters.lead_in,
        tempo=parameters.tempo,
    )
    for known in parameters.clips:
        if known.document == document:
            search = replace(
                search,
                own_beats=search.own_beats if known.beats is None else tuple(known.beats),
                source_bpm=known.source_bpm or search.source_bpm,
                beats=known.beats_from or search.beats,
            )
    return search


def _read(motions: Sequence[Motion], parameters: BeatsParameters, progress: Progress, share: float) -> list[Clip]:
    shared = None
    if parameters.shared_music and parameters.tempo == "robust":
        shared = tempo_of(each(motions, _channels, told=lambda done: progress("tempo", 0.1 * share * done)))
    begun = 0.0 if shared is None else 0.1 * share
    return each(
        motions,
        _clip,
        (parameters, shared),
        lambda done: progress("speed and beats", begun + (share - begun) * done),
    )


def _channels(motion: Motion) -> Array:
    return channels_of(upright_clip(motion))


def _clip(motion: Motion, parameters: BeatsParameters, shared: Tempo | None) -> Clip:
    return read_clip(motion, _search(parameters, motion.document), shared)


def run_beats(motions: Sequence[Motion], parameters: BeatsParameters, progress: Progress) -> Parts:
    """Speed, candidates, beats, period and bars of each clip separately."""
    clips = _read(motions, parameters, progress, 0.95)
    parts = {
        "clips": tables.clips_table(clips),
        "speed": tables.speed_curve(clips),
        "candidates": tables.candidates_table(clips),
        "beats": tables.beats_table(clips),
        "bars": tables.bars_table(clips),
        "warnings": tables.warnings_table([], clips),
    }
    if parameters.labels:
        parts["labels"] = tables.source_labels(clips, parameters.labels)
    progress("done", 1.0)
    return parts


def _graph(
    motions: Sequence[Motion], parameters: GraphParameters, progress: Progress, shares: tuple[float, float]
) -> tuple[list[Clip], BarGraph, list[str]]:
    read_share, graph_share = shares
    clips, warnings = on_one_skeleton(_read(motions, parameters, progress, read_share))
    graph = bar_graph(
        clips,
        parameters.threshold,
        parameters.coverage,
        parameters.allow_repeat,
        parameters.cloud_at,
        lambda done: progress("distances of bars", read_share + graph_share * done),
        spread_of(motions),
    )
    return clips, graph, [*warnings, *tables.graph_warnings(clips, graph)]


def run_graph(motions: Sequence[Motion], parameters: GraphParameters, progress: Progress) -> Parts:
    """The graph of the bars of all clips."""
    clips, graph, warnings = _graph(motions, parameters, progress, (0.5, 0.45))
    parts = {
        "clips": tables.clips_table(clips),
        "bars": tables.bars_table(clips),
        "graph": tables.graph_part(clips, graph),
        "warnings": tables.warnings_table(warnings, clips),
    }
    if parameters.labels:
        parts["labels"] = tables.source_labels(clips, parameters.labels)
    progress("done", 1.0)
    return parts


def edges(graph: Part, wish: EdgesWish) -> Answer:
    """Edges and components of the graph with another threshold. Raises AnalysisError `old-result`."""
    if "jumps" not in graph.arrays:
        raise AnalysisError(
            "old-result", "This graph does not hold the jumps beyond its threshold.", remedy="Make the graph again."
        )
    jumps, distances = graph.arrays["jumps"], graph.arrays["jump_distances"]
    near = distances <= wish.threshold
    steps = graph.arrays["pairs"][graph.arrays["natural"].astype(bool)]
    pairs = np.concatenate([jumps[near], steps])
    components = strong_components(len(graph.data["nodes"]), pairs[:, 0], pairs[:, 1])
    listed = min(wish.most, int(near.sum()))
    return Answer(
        GraphEdges(
            threshold=wish.threshold,
            least=float(distances.min(initial=np.inf)) if len(distances) else None,
            greatest=float(distances.max(initial=0.0)) if len(distances) else None,
            edges_in_all=len(pairs),
            edges=[
                *(GraphEdge(first=int(a) + 1, second=int(b) + 1, distance=0.0, natural=True) for a, b in steps),
                *(
                    GraphEdge(first=int(a) + 1, second=int(b) + 1, distance=float(d), natural=False)
                    for (a, b), d in zip(jumps[:listed], distances[:listed], strict=True)
                ),
            ],
            components=components.tolist(),
        )
    )


def run_dance(motions: Sequence[Motion], parameters: DanceParameters, progress: Progress) -> Parts:
    """A new dance to a tempo or to beats of music."""
    grid = _grid(parameters)
    clips, graph, warnings = _graph(motions, parameters, progress, (0.4, 0.3))
    progress("path", 0.72)
    choice = _choice(parameters)
    stage = choice.stage
    fps = parameters.fps or clips[0].fps

    def make(plan: Plan, frames: int, blend: Blend = parameters.blend) -> Dance:
        beats, warp, placement = parameters.blend_beats, parameters.warp, parameters.placement
        return dance_of(clips, graph.bars, plan, fps, blend, beats, warp, placement, frames)

    dancers, choice = make_dancers(clips, graph, grid, fps, choice, _group(parameters), make)
    progress("motion", 0.78)
    if parameters.lock_feet:
        dancers = [replace(dancer, dance=lock_feet_of(clips, dancer.dance, fps)) for dancer in dancers]
    progress("figures", 0.84)
    first, frames = dancers[0].plan, frame_count(dancers[0].plan.grid, fps)
    classic = None
    if parameters.blend != "classic":
        classic = turn_dance(clips, first, make(first, frames, "classic"), fps, choice)
    search = _search(parameters, "")
    own = cut_dance(dancers[0].dance, frames)
    measured = measure(clips, own, classic, first, fps, search, stage if len(dancers) == 1 else None)
    parts: dict[str, Part] = {
        "path": tables.path_table(clips, graph.bars, first),
        "transitions": measured.transitions,
        "metrics": measured.metrics,
    }
    if len(dancers) > 1:
        figures, near = measure_group(clips, dancers, measured, fps, search, stage)
        parts |= figures
        warnings += near
    outside = dict(parts["metrics"].data["rows"])["outside_stage"]
    warnings += tables.stage_warnings(clips, outside, stage, len(dancers) > 1)
    parts["warnings"] = tables.warnings_table(warnings, clips)
    if not parameters.dry_run:
        naming = Naming(
            parameters.name,
            parameters.bars,
            parameters.bpm,
            parameters.seed,
            parameters.model_dump_json(exclude_defaults=True),
            parameters.labels,
        )
        parts["clips"] = tables.clips_table(clips)
        parts["graph"] = tables.graph_part(clips, graph)
        parts["speed"] = tables.dance_curve(measured.watched.speed, measured.watched.beats, first.grid, fps)
        whole = motion_grid(grid, first.pulse)
        parts["clip"] = Part("clip", clip=make_clip(clips, dancers, whole, fps, naming, motions))
    progress("done", 1.0)
    return parts


def _check(parameters: BeatsParameters, documents: Sequence[str]) -> None:
    """Check parameters independently of the clips."""
    named = [clip.document for clip in parameters.clips]
    if isinstance(parameters, DanceParameters):
        _grid(parameters)
        _loudness(parameters)
        bars = bars_of_each(parameters.bars, _group(parameters))
        if parameters.pulse is not None:
            check_pulse(bars, Fraction(parameters.pulse))
        named += [allowed.document for allowed in parameters.allowed if allowed.document is not None]
    for document in named:
        if document not in documents:
            raise AnalysisError(
                "unknown-clip",
                f"The parameters name {document!r}, which is not one of the documents.",
                remedy="Name documents of the selection.",
            )


def _grid(parameters: DanceParameters) -> Array:
    if parameters.bars > MOST_OUT:
        raise AnalysisError(
            "too-many-bars",
            f"{parameters.bars} bars were requested; a dance may have {MOST_OUT}.",
            remedy="Ask for fewer.",
            most=MOST_OUT,
        )
    if parameters.music is not None and parameters.bpm is None:
        music = parameters.music
        return music_grid(
            music.beats, parameters.bars, music.downbeat - 1, float(Fraction(music.factor)), music.beats_per_bar
        )
    if parameters.bpm is None or parameters.music is not None:
        raise AnalysisError(
            "bpm-out-of-range",
            "The tempo is to be given either as bpm or by music.",
            remedy="Give a bpm from 40 to 240, or the beats of music, not both.",
        )
    return even_grid(check_bpm(parameters.bpm), parameters.bars)


def _loudness(parameters: DanceParameters) -> Loudness | None:
    music = parameters.music
    beats, levels = (None, None) if music is None else (music.beats, music.loudness)
    return check_loudness(beats, levels, needed=parameters.energy > 0)


def _choice(parameters: DanceParameters) -> Choice:
    wishes = [
        Wish(
            None if allowed.position is None else allowed.position - 1,
            tuple(bar - 1 for bar in allowed.bars),
            allowed.document,
            allowed.label,
        )
        for allowed in parameters.allowed
    ]
    if parameters.start is not None:
        wishes.append(Wish(0, (parameters.start - 1,)))
    if parameters.end is not None:
        wishes.append(Wish(-1, (parameters.end - 1,)))
    size = parameters.stage
    stage = Stage(size) if isinstance(size, float) else None
    if isinstance(size, StageSize):
        stage = Stage(None, size.width, size.depth)
    return Choice(
        None if parameters.pulse is None else Fraction(parameters.pulse),
        parameters.max_stretch,
        parameters.strategy,
        parameters.seed,
        parameters.repeat_cost,
        parameters.max_run,
        tuple(wishes),
        parameters.novelty,
        parameters.energy,
        _loudness(parameters),
        stage,
        float(np.radians(parameters.stage_turn)),
        None if parameters.facing is None else float(np.radians(parameters.facing)),
    )


def _group(parameters: DanceParameters) -> Group | None:
    wish = parameters.dancers
    return None if wish is None else Group(wish.count, wish.mode, wish.delay, wish.spacing, wish.mirrored)


_CLIPS = PartInfo("table", "Each clip: rate, candidates, beats, period, bars, and which beats were used")
_BARS = PartInfo("table", "Bars: four beats, lead-in, the beat after, tempo")
_LABELS = PartInfo("table", "Motion names to write: document, name, first and last frame")
_GRAPH = PartInfo("graph", "Bars and which may follow which, with distances in body sizes")
_WARNINGS = PartInfo("table", "Part to show")

_RULES = {"tempo": "2 (of the motion itself)", "beats": "2 (auto: more bars at the same tempo)"}

BEATS = Analysis(
    name="beats",
    title="Beats and bars",
    description="Motion beats of dance clips, where the body rests for a moment, their period, and bars of four.",
    parameters=BeatsParameters,
    parts={
        "clips": _CLIPS,
        "speed": PartInfo("curve", "Speed of the body over time, with its beats"),
        "candidates": PartInfo("table", "Every minimum of the speed, and why it is a beat or is not"),
        "beats": PartInfo("table", "The beats"),
        "bars": _BARS,
        "warnings": _WARNINGS,
        "labels": _LABELS,
    },
    run=run_beats,
    spreads=True,
    check=_check,
    rules=_RULES,
    pictures=BEATS_PICTURES,
)

MOTION_GRAPH = Analysis(
    name="motion-graph",
    title="Motion graph",
    description="Possible transitions between bars of dance clips, by distances of poses and movement, without dead "
    "ends.",
    parameters=GraphParameters,
    parts={"clips": _CLIPS, "bars": _BARS, "graph": _GRAPH, "warnings": _WARNINGS, "labels": _LABELS},
    run=run_graph,
    spreads=True,
    check=_check,
    rules=_RULES,
    pictures=GRAPH_PICTURES,
    operations={
        "edges": ResultUse("Which bar may follow which with another threshold", EdgesWish, GraphEdges, edges),
    },
    prepare=lambda parts: parts["graph"],
)

DANCE = Analysis(
    name="dance",
    title="Dance to a tempo",
    description="A new dance of any length to a tempo or to music, made of bars of dance clips, beat on beat.",
    parameters=DanceParameters,
    parts={
        "clip": PartInfo("clip", "The new dance"),
        "path": PartInfo("table", "Its bars in order: which bar of which clip, when, and how it is reached"),
        "transitions": PartInfo("table", "Its jumps: when, how far, how smooth, and the same for the classic blend"),
        "metrics": PartInfo("table", "Beat alignment, and smoothness relative to the sources"),
        "dancers": PartInfo("table", "Of several dancers: when each dances, its bars, beat alignment and way"),
        "places": PartInfo("table", "Of several dancers: where each is on the floor at each beat, metres"),
        "speed": PartInfo("curve", "Speed of the new dance with its beats and the grid"),
        "graph": _GRAPH,
        "clips": _CLIPS,
        "warnings": _WARNINGS,
    },
    run=run_dance,
    spreads=True,
    check=_check,
    rules={**_RULES, "path": "2 (novelty)"},
    pictures=DANCE_PICTURES,
)
