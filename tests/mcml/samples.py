"""Valid documents of every kind: hand-written, converted from generated captures, drawn at random."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO

from hypothesis import Phase, given, seed, settings

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.language.elements import from_head
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream
from mcml_service.demo import body, face
from tests.builders import ASF, FACE, HTR, MCML, amc, bvh
from tests.mcml.strategies import documents, small_document

EMPTY = b'<mcml version="1.0"><header/><skeleton/><motion><frames>0</frames></motion></mcml>'

MARKERS = b"""<mcml version="1.0"><header><num_segments>4</num_segments></header><skeleton><bone><name>a</name></bone>
<bone convention="marker"><name>b</name><position>1 2 3</position><end_site position="0 0 1"/>
<bone><name>c</name></bone><bone convention="shape"><name>d</name><order>weight</order></bone></bone></skeleton>
<motion><frames>4</frames><frame id="x"/><frame id="7">
<frame_bone name="b" Tx="1" residual="-1"/><frame_bone name="a"/></frame><frame id="7"><motion_name>x</motion_name>
<frame_bone name="c" Rx="0"/></frame><frame id="8"><frame_bone name="a" Tx="1" Ty="-0.0"/><frame_bone name="c"/>
<frame_bone name="d" weight="0.5"/></frame>
</motion></mcml>"""

FIGURES = b"""<mcml version="1.0">
<header> <filetype> htr </filetype> <datatype> HTRS </datatype> <filename> quickwalk.htr </filename>
  <version> 1.0 </version> <skeleton_name> Billy </skeleton_name> <units mass="1.0" length="0.45" angle="degree"/>
  <num_frames> 60 </num_frames> </header>
<root order="Tx Ty Tz Rx Ry Rz" axis="XYZ" position="0 0 0" orientation="0 0 0"/> <skeleton> <bone id="1">
  <name> l femur </name> <direction> 0.34202 0.939693 0 </direction> <length> 6.8845 </length>
  <axis> 0 0 20 XYZ </axis> <dof> rx ry rz </dof> <limits> -160.0 20.0 </limits> <limits> -70.0 70.0 </limits>
  <limits> 60.0 70.0 </limits> <bone id="2"> <name> l tibia </name> <bone id="3"> <name> l foot </name> </bone> </bone>
  </bone> </skeleton>
<motion> <frames> 89 </frames> <frametime> 0.3333 </frametime> <frame id="1">
  <motion_name> left-arm-front </motion_name> <frame_bone name="hips" Tx="-5.61" Ty="37.37" Tz="-68.55" Rx="-1.9"
  Ry="4.16" Rz="-5.28"/> <frame_bone name="chest" Tx="-5.61" Ty="37.37" Tz="-68.55" Rx="-1.9" Ry="4.16" Rz="-5.28"/>
  </frame> </motion></mcml>"""
"""The founding paper's Figures 1 to 3 in one document."""

PAPER = (
    FIGURES.replace(b" 60 ", b" 1 ").replace(b" 89 ", b" 1 ").replace(b'"hips"', b'"Root"').replace(b"chest", b"l foot")
)
"""The figures with counts and bone names that agree, which those of the paper do not."""


def hand_written() -> list[bytes]:
    """Documents that people wrote: every element, none, markers, frames of different shapes, several frames."""
    small = [small_document(frames, pretty) for frames in (0, 1, 3) for pretty in (True, False)]
    return [*small, MARKERS, EMPTY, PAPER, FACE, MCML.partition(b'mcml.dtd">\n')[2]]


def captures() -> list[bytes]:
    """Documents made from files of every format: a whole character, a face, a leg, a chain of joints."""
    character = body.clip("walk", 175.0, *body.walk(175.0, 0.05, 1.0, 5.0))
    return [
        _written(character),
        _written(_read("htr", {"htr": face.face_htr(1, seconds_each=0.03)[0]})),
        _written(_read("htr", {"htr": HTR})),
        _written(_read("asf-amc", {"asf": ASF, "amc": amc(4)})),
        _written(_read("bvh", {"bvh": bvh(5)})),
    ]


def generated(count: int, number: int = 0) -> list[bytes]:
    """That many documents with everything that heads and frames can hold; number: the seed.

    Hypothesis also draws constants of the modules that are loaded, so another choice of tests has other documents.
    """
    found: list[bytes] = []

    @seed(number)
    @settings(max_examples=count, derandomize=False, database=None, phases=[Phase.generate])
    @given(documents())
    def collect(document: bytes) -> None:
        found.append(document)

    collect()
    return found


def _read(format: str, files: Mapping[str, bytes]) -> ClipStream:
    sources = {part: SourceFile(f"a.{part}", BytesIO(content)) for part, content in files.items()}
    return FORMATS[format].read(sources, ReadOptions())


def _written(clip: ClipStream) -> bytes:
    blocks = list(clip.blocks())
    frames = sum(map(len, blocks))
    names = clip.head.skeleton.names
    return b"".join(write_document(from_head(clip.head), frames, clip.head.frame_time, blocks, names, pretty=True))
