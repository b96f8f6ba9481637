"""GLB files as three.js plays them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from mcml.formats import WRITERS
from tests.formats.scenes.clips import CLIPS, stated, told
from tests.formats.scenes.reading import expected, height, read_glb, size_of
from tests.web.test_units import vitest

MADE = ("bvh", "asf", "htr", "htr with gaps", "trc", "c3d", "hostile names", "listed 1", "base 3")


def test_joints_are_where_they_were(tmp_path: Path) -> None:
    clips = {title: CLIPS[title]() for title in MADE} | {"Z up": stated("centimetres, Z up")[0]}
    cases = []
    for number, (title, clip) in enumerate(clips.items()):
        path = tmp_path / f"{number}.glb"
        content = b"".join(WRITERS["glb"].write(replace(clip, notices=[]), "glb"))
        path.write_bytes(content)
        wanted = expected(clip, size_of(read_glb(content), clip), told(clip)[1])
        seconds = clip.head.seconds_per_frame() or 1 / 120
        # The last one would begin again from the first.
        times = [frame * seconds for frame in range(len(wanted) - 1)]
        cases.append(
            {
                "title": title,
                "path": str(path),
                "times": times,
                "positions": wanted[:-1].tolist(),
                "height": height(wanted),
            }
        )
    (tmp_path / "cases.json").write_text(json.dumps(cases))
    said = vitest("src/scene/glb.test.ts", MCML_GLB=tmp_path / "cases.json")
    print(said)
    assert f"{len(cases)} passed" in said
