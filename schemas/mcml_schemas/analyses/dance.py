"""Parameters of the dance analyses: beats, motion graph, choreography.

Ranges that have a named error (tempo, number of bars) are shown here and checked by the analysis.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from mcml_schemas.examples import DOCUMENT
from mcml_schemas.request_body import RequestBody

_DANCE: dict[str, JsonValue] = {"bpm": 120, "bars": 16, "labels": ["bars", "beats"]}
Seconds = Annotated[float, Field(ge=0, le=1e6)]
Level = Annotated[float, Field(ge=0, le=1e6)]
Twofold = Literal["1/2", "1", "2"]


class ClipBeats(RequestBody):
    """Corrections of one clip by a person; all other values are detected."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"document": DOCUMENT, "beats_from": "tracked"}]})

    document: str = Field(description="Id of the clip", examples=[DOCUMENT])
    beats: list[Seconds] | None = Field(
        None,
        max_length=100_000,
        description="Beats set by hand, in seconds from the first frame, instead of those found",
        examples=[[0.52, 1.04, 1.55, 2.08, 2.6]],
    )
    source_bpm: float | None = Field(
        None, ge=25, le=240, description="Tempo that the dancer heard, beats a minute", examples=[120.0]
    )
    beats_from: Literal["auto", "detected", "tracked"] | None = Field(
        None, description="As the parameter of this name, for this clip", examples=["tracked"]
    )


class BeatsParameters(RequestBody):
    """How beats and bars are found."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"beats_from": "auto", "labels": ["bars"]}]})

    source_bpm: float | None = Field(
        None,
        ge=25,
        le=240,
        title="Tempo of the source",
        description="Beats a minute that the dancers heard, where known; else the period is found",
        examples=[120.0],
    )
    tempo: Literal["robust", "paper"] = Field(
        "robust",
        title="Tempo",
        description="robust: of the whole motion, its rests, braking and bounce. paper: of the beats that were found",
        examples=["robust"],
    )
    shared_music: bool = Field(
        False,
        description="All clips were danced to the same music: they have one tempo, found in all",
        examples=[False],
    )
    beats_from: Literal["auto", "detected", "tracked"] = Field(
        "auto",
        title="Beats",
        description="detected: rests that are deep enough. tracked: the steadiest row of rests. auto: for each clip, "
        "the one that gives more bars at the same tempo (within 2 %); the answer states the choice and its reason",
        examples=["auto"],
    )
    interval_tolerance: Annotated[float, Field(gt=0, le=1)] | Literal["window"] = Field(
        0.2,
        title="Tolerance",
        description="How far an interval of a bar may be from the period, as a part of it; window: a third of a second",
        examples=[0.2],
    )
    stride: Literal[1, 4] = Field(
        4, description="4: bars do not overlap. 1: a bar may start on every beat", examples=[4]
    )
    k2: float = Field(
        2 / 15, ge=0, le=2, title="Least dip", examples=[0.133],
        description="F2: how far the speed at a beat is below the local mean, in mean speeds of the clip",
    )  # fmt: skip
    k3: float = Field(
        1.0, ge=0, le=10, title="Greatest rest", examples=[1.0],
        description="F3: the greatest speed at a beat, in mean speeds of the clip",
    )  # fmt: skip
    smooth: float = Field(
        0.04, ge=0, le=0.5, title="Smoothing", examples=[0.04],
        description="Standard deviation of the Gaussian over the positions, seconds; 0: none, as the thesis",
    )  # fmt: skip
    difference: Literal["central", "forward"] = Field(
        "central", description="forward: as the thesis; beats come half a frame early", examples=["central"]
    )
    locate: bool = Field(
        True,
        title="Middle of the rest",
        description="Beats in the middle of the rest. false: at the minimum of the smoothed speed, as the thesis",
        examples=[True],
    )
    lead_in: Literal["beat", "third"] = Field(
        "beat",
        description="Where the beat before and after a bar comes from. third: always a third of the bar, as the thesis",
        examples=["beat"],
    )
    clips: list[ClipBeats] = Field(
        default_factory=list, max_length=2000, description="Corrections of single clips", examples=[[]]
    )
    labels: list[Literal["bars", "beats"]] = Field(
        default_factory=list,
        description="Motion names to write: bar-1, bar-2 … over the bars, beat on the frames of beats",
        examples=[["bars", "beats"]],
    )


class GraphParameters(BeatsParameters):
    """How bars are joined to a graph."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"threshold": 0.1}]})

    threshold: float | None = Field(
        None,
        ge=0,
        le=10,
        description="Greatest distance of a jump, in body sizes: 0.05 is very close, above 0.15 it slides visibly. "
        "Without it the least is taken that joins `coverage` of the bars",
        examples=[0.1],
    )
    coverage: float = Field(
        0.8, gt=0, le=1, description="Part of the bars that the threshold has to join", examples=[0.8]
    )
    allow_repeat: bool = Field(False, description="Whether a bar may follow itself", examples=[False])
    cloud_at: Literal["entry", "first beat"] = Field(
        "entry",
        description="Frame that the end of a bar is compared with. first beat: as in the thesis's program",
        examples=["entry"],
    )


class EdgesWish(RequestBody):
    """Another threshold for a graph that was made."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"threshold": 0.08}]})

    threshold: float = Field(ge=0, le=10, description="Greatest distance of a jump, in body sizes", examples=[0.08])
    most: int = Field(5000, ge=0, le=20_000, description="Most jumps to be listed, the nearest first", examples=[5000])


class GraphEdge(BaseModel):
    """One bar after another: as in their clip, or by a jump. Bars are numbered from 1 through all clips."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"first": 3, "second": 7, "distance": 0.061, "natural": False}]}
    )

    first: int
    second: int
    distance: float = Field(description="Body sizes; 0 where the second follows the first in its clip")
    natural: bool


class GraphEdges(BaseModel):
    """A graph with another threshold.

    components: of each bar, 0 for the largest: in it a dance can continue without end. least, greatest: distances of
    the stored jumps.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "threshold": 0.08,
                    "least": 0.021,
                    "greatest": 0.31,
                    "edges_in_all": 1,
                    "edges": [{"first": 3, "second": 7, "distance": 0.061, "natural": False}],
                    "components": [0, 0, 1],
                }
            ]
        }
    )

    threshold: float
    least: float | None
    greatest: float | None
    edges_in_all: int
    edges: list[GraphEdge]
    components: list[int]


class AllowedBars(RequestBody):
    """Limits of the bars at a position, or everywhere. All given limits must hold."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"position": 1, "bars": [3]}]})

    position: int | None = Field(
        None, ge=1, le=512, description="Bar of the dance, from 1; without it every one", examples=[1]
    )
    bars: list[int] = Field(
        default_factory=list, max_length=2000, description="Bars of the graph, numbered from 1", examples=[[3, 7]]
    )
    document: str | None = Field(None, description="Bars of this clip", examples=[DOCUMENT])
    label: str | None = Field(None, description="Bars of which this motion name covers half", examples=["chorus"])


BeatsPerBar: TypeAlias = Annotated[int, Field(ge=2, le=4)]


class Music(RequestBody):
    """Beats of music, as found in an upload and perhaps corrected."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"beats": [0.4, 0.9, 1.4, 1.9, 2.4], "downbeat": 1}]})

    beats: list[Seconds] = Field(
        max_length=20_000, description="Seconds, ascending", examples=[[0.4, 0.9, 1.4, 1.9, 2.4]]
    )
    downbeat: int = Field(1, ge=1, description="Which beat, from 1, the first bar starts on", examples=[1])
    factor: Twofold = Field("1", description="2: the tempo was found at half its speed. 1/2: at double", examples=["1"])
    beats_per_bar: BeatsPerBar = Field(
        4, description="Beats of a bar. Of music in three, each bar is one beat of the dance", examples=[4]
    )
    loudness: list[Level] | None = Field(
        None,
        max_length=20_000,
        description="RMS of the sound from each beat to the next, as many as beats; any scale",
        examples=[[0.1, 0.12, 0.2, 0.21, 0.2]],
    )


class StageSize(RequestBody):
    """A rectangular stage; the dance starts in its middle."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"width": 8.0, "depth": 5.0}]})

    width: float = Field(gt=0, le=1000, description="Along X, metres", examples=[8.0])
    depth: float = Field(gt=0, le=1000, description="Along Z (with Z up: along Y), metres", examples=[5.0])


StageRadius: TypeAlias = Annotated[float, Field(gt=0, le=1000)]


class Dancers(RequestBody):
    """Several dancers on one stage."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"count": 3, "mode": "canon", "delay": 2}]})

    count: int = Field(ge=2, le=6, description="Number of dancers", examples=[3])
    mode: Literal["unison", "canon", "free"] = Field(
        "unison",
        description="unison: all dance the same bars. canon: each starts some bars after the one before. free: each "
        "has a path of its own that keeps away from the others",
        examples=["unison"],
    )
    delay: int = Field(1, ge=1, le=8, description="Canon: bars of music from one dancer to the next", examples=[2])
    spacing: float = Field(
        1.2, ge=0.5, le=10, description="Distance of neighbours at the start, metres", examples=[1.2]
    )
    mirrored: bool = Field(
        False,
        description="Unison and canon: every second dancer dances with left and right exchanged",
        examples=[False],
    )


class DanceParameters(GraphParameters):
    """Parameters of a dance."""

    model_config = ConfigDict(json_schema_extra={"examples": [_DANCE]})

    bpm: float | None = Field(
        None,
        title="Tempo",
        description="Beats a minute of the music, 40 to 240, unless music gives it",
        examples=[120.0],
        json_schema_extra={"minimum": 40, "maximum": 240},
    )
    music: Music | None = Field(None, description="Beats of a piece of music instead of a tempo", examples=[None])
    bars: int = Field(
        16, ge=1, description="Bars of music, at most 512", examples=[16], json_schema_extra={"maximum": 512}
    )
    pulse: Twofold | None = Field(
        None,
        description="Music beats to a motion beat. Without it the one that suits the clips' own tempo",
        examples=["1"],
    )
    max_stretch: float = Field(
        2.0, ge=1, le=8, description="How many times faster or slower than recorded a bar may be", examples=[2.0]
    )
    fps: float | None = Field(
        None, ge=10, le=480, title="Frame rate", description="Of the new clip; else the first clip's", examples=[60.0]
    )
    strategy: Literal["beam", "random"] = Field(
        "beam",
        description="beam: the cheapest path, smooth and without loops. random: a walk, as the thesis",
        examples=["beam"],
    )
    seed: int = Field(
        0,
        ge=0,
        le=2**32 - 1,
        description="Of the random walk; with novelty, of other paths of the beam. 0: the cheapest path",
        examples=[7],
    )
    repeat_cost: float = Field(
        1.0, ge=0, le=100, description="Cost of repeating the previous bar, in thresholds", examples=[1.0]
    )
    novelty: float = Field(
        0.5,
        ge=0,
        le=100,
        description="Cost of bars that were danced in the last 16 bars (squared) or more often than others, in "
        "thresholds. 0: the smoothest path, which uses few bars",
        examples=[0.5],
    )
    energy: float = Field(
        0.0,
        ge=0,
        le=100,
        description="Cost of bars whose hands and feet move otherwise than the loudness of the music asks, in "
        "thresholds. 0: the loudness does not matter",
        examples=[4.0],
    )
    stage: StageRadius | StageSize | None = Field(
        None,
        description="Stage to stay on: its radius in metres, or width and depth. The dance starts in the middle, at "
        "the origin",
        examples=[3.0],
    )
    stage_turn: float = Field(
        10.0,
        ge=0,
        le=45,
        title="Turn on the stage",
        description="Most degrees that the dancer is turned in a bar to stay on the stage",
        examples=[10.0],
    )
    facing: float | None = Field(
        None,
        ge=-360,
        le=360,
        description="Direction that the dancer faces at the first beat, degrees to the left of +Z (with Z up: of -Y)",
        examples=[0.0],
    )
    dancers: Dancers | None = Field(
        None,
        description="Several dancers instead of one: how many, in unison, in canon or free, and their distance. The "
        "clip has all bodies; joints of the second dancer are named dancer2:Root and so on",
        examples=[None],
    )
    max_run: int = Field(4, ge=1, le=512, description="Consecutive bars in the order of their clip", examples=[4])
    start: int | None = Field(None, ge=1, description="Bar of the graph, from 1, to begin with", examples=[1])
    end: int | None = Field(None, ge=1, description="Bar of the graph, from 1, to end with", examples=[None])
    allowed: list[AllowedBars] = Field(
        default_factory=list, max_length=2000, description="Bars allowed at each position", examples=[[]]
    )
    blend: Literal["hold", "classic", "none"] = Field(
        "hold",
        description="hold: the last pose of a bar holds into the next beat. classic: the bar plays on. none: a cut",
        examples=["hold"],
    )
    blend_beats: float = Field(1.0, gt=0, le=1, description="Length of a transition, motion beats", examples=[1.0])
    warp: Literal["beats", "uniform"] = Field(
        "beats", description="beats: every beat on the grid. uniform: only the ends, as the thesis", examples=["beats"]
    )
    placement: Literal["cloud", "facing"] = Field(
        "cloud",
        description="cloud: bars placed where body and movement meet best. facing: by heading and place of the root",
        examples=["cloud"],
    )
    lock_feet: bool = Field(
        False,
        title="Lock planted feet",
        description="Feet that are planted in the clips stay in place, also while a transition or the tempo moves them",
        examples=[False],
    )
    dry_run: bool = Field(False, description="Only the path and its figures, no clip", examples=[False])
    name: str = Field("dance", min_length=1, max_length=200, description="Name of the new clip", examples=["dance"])
