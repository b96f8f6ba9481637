"""The positions that the studio draws are those of the API: of BVH, ASF/AMC, HTR and markers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcml.formats import FORMATS
from mcml.motion.skeleton import Convention
from tests.builders import ASF, FACE, HTR, TRC, amc, bvh, c3d_file
from tests.conftest import shared_folder
from tests.motion.random_clips import FORMAT_OF, random_clip
from tests.web.conftest import Served
from tests.web.test_units import vitest

NAMES = {"bvh": ("clip.bvh",), "htr": ("clip.htr",), "asf-amc": ("clip.asf", "clip.amc")}
REAL = {
    "bvh": ("edge/rotation_first_root.bvh", "exporters/olympe_root.bvh", "exporters/classic_example1.bvh"),
    "asfamc": ("cmu16/16.asf cmu16/run_veer_left_16_48.amc", "cmu_misc/09-run.asf cmu_misc/09_06-run.amc"),
    "htr": ("maya_tail_export.htr", "xbot_walk_f_mixamo.com.htr"),
    "c3d": ("edge/shd01.c3d",),
    "trc": ("dataWithNaNsOfDifferentCases.trc", "subject01_synthetic_marker_data.trc"),
}


def stored(served: Served, title: str, files: dict[str, bytes]) -> tuple[str, str]:
    with served.client() as client:
        parts = [("file", (name, content)) for name, content in files.items()]
        answer = client.post("/documents", files=parts, data={"frame_time": "0.01"} if "amc" in title else {})
    assert answer.status_code == 201, answer.text
    return title, str(answer.json()["documents"][0]["id"])


def generated(seeds: range) -> dict[str, dict[str, bytes]]:
    """Clips of every convention, whose joints turn in all orders, and some of which move in their parents."""
    found = {
        "bvh by hand": {"a.bvh": bvh(600)},
        "amc by hand": {"a.asf": ASF, "a.amc": amc(5)},
        "htr with gaps": {"a.htr": HTR},
        "trc by hand": {"a.trc": TRC},
        "c3d": {"a.c3d": c3d_file(40, 12)},
        "face": {"face.mcml": FACE},
    }
    for convention in (Convention.LISTED, Convention.FIXED, Convention.BASE):
        for seed in seeds:
            target = FORMAT_OF[convention]
            clip = random_clip(convention, seed, moving=seed % 2 == 1, radians=seed % 3 == 2)
            text = {name: b"".join(FORMATS[target].write(clip, name[-3:])) for name in NAMES[target]}
            found[f"{target.replace('-', ' ')} {seed}"] = text
    return found


def compare(served: Served, files: dict[str, dict[str, bytes]]) -> None:
    documents = [stored(served, title, content) for title, content in files.items()]
    said = vitest("src/motion/loading/drawn.test.ts", MCML_SERVER=served.url, MCML_DOCUMENTS=json.dumps(documents))
    assert f"{2 * len(documents)} passed" in said


@pytest.mark.slow
def test_generated_motion_is_drawn_where_it_is(open_studio: Served) -> None:
    compare(open_studio, generated(range(6)))


@pytest.mark.slow
def test_real_motion_is_drawn_where_it_is(open_studio: Served) -> None:
    folder = shared_folder()
    if folder is None:
        pytest.skip("the real capture files are not here (set MCML_SHARED to their folder)")
    paths = {name: [folder / kind / part for part in name.split()] for kind in REAL for name in REAL[kind]}
    compare(open_studio, {name: {path.name: Path(path).read_bytes() for path in some} for name, some in paths.items()})
