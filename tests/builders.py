"""The smallest clips and documents that show a point."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml.language import joint_names
from mcml.motion.skeleton import Skeleton
from mcml_service.actions.importing import import_pool
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.local_secret import PREFIX
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.c3d_writer import c3d_bytes

if TYPE_CHECKING:
    from fastapi.testclient import TestClient


def bvh(frames: int = 3, seed: int = 0, names: Sequence[str] = ("Root", "Spine", "Head"), decimals: int = 4) -> bytes:
    """A chain of joints in BVH with random but plausible numbers."""
    rng = np.random.default_rng(seed)
    lines = ["HIERARCHY"]
    for depth, name in enumerate(names):
        pad = "\t" * depth
        lines += [
            f"{pad}{'JOINT' if depth else 'ROOT'} {name}",
            f"{pad}{{",
            f"{pad}\tOFFSET 0.00 {10.5 * bool(depth)} 0.00",
        ]
        channels = "CHANNELS 3 Zrotation Xrotation Yrotation"
        if not depth:
            channels = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
        lines.append(f"{pad}\t{channels}")
    pad = "\t" * len(names)
    lines += [f"{pad}End Site", f"{pad}{{", f"{pad}\tOFFSET 0.00 5.25 0.00", f"{pad}}}"]
    lines += ["\t" * depth + "}" for depth in reversed(range(len(names)))]
    lines += ["MOTION", f"Frames: {frames}", "Frame Time: 0.0083333"]
    values = np.cumsum(rng.normal(0, 1.5, (frames, 3 + 3 * len(names))), axis=0)
    lines += [" ".join(f"{value:.{decimals}f}" for value in row) for row in values]
    return ("\n".join(lines) + "\n").encode()


ASF = b"""# a comment
:version 1.10
:name leg
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   # kept as it is
   two lines
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 2
     name lfemur
     direction 0.34202 -0.939693 0
     length 7.34031
     axis 0 0 20  XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 1
     name lhipjoint
     direction 0.567149 -0.783011 0.255413
     length 2.28399
     axis 0 0 0  XYZ
  end
  begin
     id 3
     name ltibia
     direction 0.34202 -0.939693 0
     length 6.9833
     axis 0 0 20   XYZ
    dof rx
    limits (-10.0 170.0)
  end
:hierarchy
  begin
    root lhipjoint
    lhipjoint lfemur
    lfemur ltibia
  end
"""
"""A leg; bones numbered and listed in an order of their own."""


def amc(frames: int = 2) -> bytes:
    lines = ["#!OML:ASF leg.asf", ":FULLY-SPECIFIED", ":DEGREES"]
    for frame in range(1, frames + 1):
        lines += [str(frame), f"root 0.{frame} 17.5 -3 1 2 -0.5", f"lfemur {frame} 2.5 -3", f"ltibia {10 + frame}"]
    return ("\n".join(lines) + "\n").encode()


HTR_HEAD = """# made by hand
[Header]\t# Header keywords are followed by a single value
# KeyWord<space>Value<CR>
FileType htr
DataType HTRS
FileVersion 1
NumSegments 3
NumFrames 2
DataFrameRate 30
EulerRotationOrder ZYX
CalibrationUnits mm
RotationUnits Degrees
GlobalAxisofGravity Y
BoneLengthAxis Y
ScaleFactor 1.00
[SegmentNames&Hierarchy]
# ObjectName<tab>ParentObjectName<CR>
m:Hand\tm:Arm
m:Arm\tHips
Hips\tGLOBAL
[BasePosition]
Hips\t0.902781\t1023.85\t1740.59\t-45.1\t-87.2\t-45.0\t3.937008
m:Arm\t0\t250.0\t0\t10\t0\t0\t200
m:Hand 0 200 0 0 0 0 80
"""
HTR_V1 = """[m:Hand]
# Tx<tab>Ty<tab>Tz<tab>Rx<tab>Ry<tab>Rz<tab>BoneScaleFactor<CR>
0\t0.5\t0\t0\t1\t2\t3\t1.000000
1\t0.5\t0\t0\t1.5\t2.5\t3.5\t1.000000
[m:Arm]
0\t0\t0\t0\t-0\t-0.0\t1e-011\t1
1\t0\t0\t0\t4\t5\t6\t1
[Hips]
0\t10\t20\t30\t7\t8\t9\t1
1\t11\t21\t31\t7.5\t8.5\t9.5\t1
[EndOfFile]
"""
HTR_V2 = """Frame 0:
m:Hand 0.5 0 0 1 2 3 1.000000
m:Arm 0 0 0 -0 -0.0 1e-011 1
Hips 10 20 30 7 8 9 1
Frame 1:
m:Hand 0.5 0 0 1.5 2.5 3.5 1.000000
m:Arm 0 0 0 4 5 6 1
Hips 11 21 31 7.5 8.5 9.5 1
[EndOfFile]
"""
HTR = (HTR_HEAD + HTR_V1).replace("1\t0\t0\t0\t4\t5\t6", "1\t0\t0\t0" + 3 * "\t9999999").encode()
"""An arm; in the second frame the rotation of one bone is missing."""

MCML = b"""<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE mcml SYSTEM "mcml.dtd">
<mcml version="1.0">
  <header><filename>hand.mcml</filename></header>
  <root name="Root" order="Tx Ty Tz Rx Ry Rz" axis="XYZ" position="0 0 0" orientation="0 0 0"/>
  <skeleton><bone id="1"><name>left_up_leg</name><dof>rx ry rz</dof></bone></skeleton>
  <motion>
    <frames>3</frames>
    <frametime>0.0333</frametime>
    <frame id="1"><motion_name>left-leg-flexion</motion_name>
      <frame_bone name="Root" Tx="1.5" Ty="2" Tz="-0.0" Rx="1e-3" Ry="4" Rz="5"/>
      <frame_bone name="left_up_leg" Rx="10" Ry="11" Rz="12"/></frame>
    <frame id="2"><motion_name>left-leg-flexion</motion_name><motion_name>walk</motion_name>
      <frame_bone name="Root" Tx="1.6" Ty="2" Tz="-0.0" Rx="1e-3" Ry="4" Rz="5"/>
      <frame_bone name="left_up_leg"/></frame>
    <frame id="5"><motion_name>walk</motion_name>
      <frame_bone name="left_up_leg" Rx="20" Ry="21" Rz="22"/></frame>
  </motion>
</mcml>
"""


FACE = b"""<mcml version="1.0"><header><units angle="rad"/><dataframe_rate>30</dataframe_rate></header>
<root order="Ry Rx Rz" position="0 0 0" name="Head" convention="listed"/>
<skeleton><bone convention="shape"><name>JawOpen</name><order>weight</order></bone>
<bone convention="shape"><name>EyeBlinkLeft</name><order>weight</order></bone></skeleton>
<motion><frames>4</frames>
<frame id="1"><frame_bone name="Head" Rx="0.1" Ry="0.2" Rz="-0.1"/><frame_bone name="JawOpen" weight="0.25"/>
<frame_bone name="EyeBlinkLeft" weight="0"/></frame>
<frame id="2"><motion_name>blink</motion_name><frame_bone name="Head" Rx="0.3" Ry="0.2" Rz="0"/>
<frame_bone name="JawOpen" weight="0.75"/><frame_bone name="EyeBlinkLeft" weight="1.053"/></frame>
<frame id="3"><frame_bone name="Head"/><frame_bone name="JawOpen"/><frame_bone name="EyeBlinkLeft"/></frame>
<frame id="4"><frame_bone name="Head" Rx="0.2" Ry="0" Rz="0.1"/><frame_bone name="JawOpen" weight="0.5"/>
<frame_bone name="EyeBlinkLeft" weight="0.1"/></frame></motion></mcml>"""
"""A head with two blend shapes; a frame without samples."""


def mcml_of(ids: Sequence[int | str]) -> bytes:
    """A document of one bone that turns by a degree a frame, and frames with these ids."""
    head, _, rest = MCML.decode().partition("    <frames>3</frames>")
    frames = [
        f'<frame id="{one}"><frame_bone name="left_up_leg" Rx="{n}"/></frame>\n' for n, one in enumerate(ids, start=1)
    ]
    time = "<frametime>0.0333</frametime>"
    return f"{head}<frames>{len(ids)}</frames>{time}{''.join(frames)}{rest[rest.index('  </motion>') :]}".encode()


def source(name: str, content: bytes) -> SourceFile:
    return SourceFile(name, io.BytesIO(content))


def read_by(monkeypatch: pytest.MonkeyPatch, processes: int) -> None:
    """Let so many processes read the clips of imports: threads of the test's runner do nothing that a fork harms."""
    monkeypatch.setenv("MCML_IMPORT_PROCESSES", str(processes))
    monkeypatch.setattr(import_pool, "may_fork", lambda: True)


def store(database: Database, files: dict[str, bytes], **options: object) -> list[str]:
    """Import files; the uuids. Raises the first problem."""
    result = import_files(
        database,
        [source(name, content) for name, content in files.items()],
        ImportOptions(**options),  # type: ignore[arg-type]
        Settings(),
    )
    for _, error in result.problems:
        raise error
    return [document.uuid for document in result.documents]


def upload(client: TestClient, files: dict[str, bytes], **form: object) -> dict[str, object]:
    """Upload over HTTP; the answer's JSON."""
    answer = client.post(
        "/api/v1/documents", files=[("file", (name, content)) for name, content in files.items()], data=form
    )
    answer.raise_for_status()
    result: dict[str, object] = answer.json()
    return result


def lines_of(content: Iterator[bytes]) -> list[bytes]:
    return b"".join(content).splitlines()


TRC = b"""PathFileType\t4\t(X/Y/Z)\thand.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames
120.00\t120.00\t4\t3\tmm\t120.00\t1\t4
Frame#\tTime\tR.Wrist\t\t\t*0\t\t\tR.Wrist\t\t
\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3

11\t0.083\t273.71817\t-56.52052\t1296.20001\t1.00000\t2.00000\t3.00000\t-0.00000\t5.00000\t6.00000
12\t0.092\t273.71816\t-56.52053\t1296.20002\t\t\t\t4.00000\t5.00000\t6.00000
13\t0.100\t\t\t\t1.50000\t2.00000\t3.00000\t4.00000\t5.00000\t6.00000
14\t0.108\t273.71814\t-56.52054\t1296.20003\t1.00000\t2.00000\t3.00000\t\t\t
"""


def c3d_file(
    frames: int = 6, points: int = 3, rate: float = 120.0, first: int = 11, seed: int = 0, up: str = ""
) -> bytes:
    """Points that wander, some samples missing, some residuals stated, an analog channel beside them. up: such as +Z,
    which the file shows upward on the screen."""
    rng = np.random.default_rng(seed)
    places = np.cumsum(rng.normal(0, 3, (frames, points, 3)), axis=0)
    residuals = rng.integers(0, 40, (frames, points))
    residuals[rng.random((frames, points)) < 0.2] = -1
    residuals[0] = 6
    labels = [f"marker {number}" for number in range(points)]
    return c3d_bytes(
        places,
        residuals,
        scale=-0.25,
        rate=rate,
        first=first,
        labels=labels,
        analog=np.zeros((frames, 2)),
        samples=2,
        parameters={"POINT:Y_SCREEN": (-1, (2,), up.encode())} if up else None,
    )


SECRET = PREFIX + "of-the-tests"

one_kind = pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
"""Of database, where what is tested asks nothing of it that tests of storage, edits and queries do not ask of both."""


def served(
    database: Database, settings: Settings | None = None, *, base_url: str = "http://127.0.0.1:8000"
) -> TestClient:
    """The service on a store, asked in process by the owner of the store."""
    # Here, as programs that kill tests start import this module, and the web application takes longer than their work.
    from fastapi.testclient import TestClient

    from mcml_service.app import create_app

    return TestClient(
        create_app(settings or Settings(), database, lambda: SECRET),
        base_url=base_url,
        headers={"authorization": f"Bearer {SECRET}"},
        client=("127.0.0.1", 50_000),
    )


@cache
def description() -> dict[str, Any]:
    """The API's description (OpenAPI), which nobody changes: it takes half a second to make."""
    from mcml_service.app import create_app

    made: dict[str, Any] = create_app(Settings(database="sqlite://")).openapi()
    return made


def assign(skeleton: Skeleton, extra: Sequence[tuple[str, str]] = ()) -> Skeleton:
    """The skeleton with `name` and `mapped` of every joint set."""
    return joint_names.named(skeleton, extra)[0]
