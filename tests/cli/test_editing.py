"""Commands that edit: elements, frames, history, labels, mappings; in this process, on a store of their own."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml_service.cli import app
from mcml_service.demo import body
from tests.builders import ASF, amc, bvh
from tests.laboratory.gait_files import LENGTHS, WALKING, gait_file, stand
from tests.laboratory.gait_files import walk as markers_of_walk

Run = Callable[..., str]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs a command that must end with this code; answers its output."""
    monkeypatch.setenv("MCML_DATABASE", f"sqlite:///{tmp_path / 'store.db'}")
    monkeypatch.chdir(tmp_path)

    def command(*words: str, code: int = 0, text: str | None = None) -> str:
        done = CliRunner().invoke(app, words, input=text)
        if isinstance(done.exception, McmlError):
            # What `main` turns into a message and exit code 1.
            assert code == 1, done.exception
            return str(done.exception)
        assert done.exit_code == code, done.output
        return done.output

    return command


@pytest.fixture
def walk(run: Run) -> str:
    Path("walk.bvh").write_bytes(bvh(30))
    found: str = json.loads(run("import", "walk.bvh", "--label", "walk:1-20", "--json"))["documents"][0]["id"]
    return found


def test_elements(run: Run, walk: str) -> None:
    spot = "//frame[5]/frame_bone[2]"
    before = run("element", "get", walk, spot)
    assert before.startswith("<frame_bone ")
    assert before.endswith("/>\n")
    assert "revision 2" in run("element", "set", walk, spot, "Rx=12.5", "-m", "a spike")
    assert run("element", "get", walk, f"{spot}/@Rx") == "12.5\n"
    assert run("element", "get", walk, "/mcml/motion/frame[5]/frame_bone[2]", "--revision", "1") == before
    assert "a spike" in run("history", walk)
    changed = json.loads(run("diff", walk, "1", "--json"))
    assert [(bone["first"], list(bone["channels"])) for bone in changed["bones"]] == [(5, ["Rx"])]
    assert "revision 3" in run("undo", walk)
    assert run("element", "get", walk, spot) == before
    assert "more than one" in run("element", "set", walk, "//frame/frame_bone[2]", "Rx=1", code=1)
    assert "30 edited" in run("element", "set", walk, "//frame/frame_bone[2]", "Rx=1", "--many")
    assert "another one" in run("element", "set", walk, spot, "Rx=1", "--revision", "1", code=1)
    assert "Rx" in run("element", "set", walk, spot, "Rx=fast", code=1)
    assert "NAME=VALUE" in run("element", "set", walk, spot, code=2)
    run("restore", walk, "1")
    run("element", "replace", walk, spot, text=before.replace('Rx="', 'Rx="1'))
    run("element", "insert", walk, "//frame[1]", "--where", "before", text=run("element", "get", walk, "//frame[3]"))
    run("element", "move", walk, "//frame[1]", "//frame[last()]", "--where", "after")
    run("element", "delete", walk, "//frame[last()]")
    print(before, run("element", "get", walk, spot))
    assert "~" in run("diff", walk, "1")
    Path("edits.json").write_text(json.dumps({"edits": [{"do": "delete", "xpath": f"//frame[{n}]"} for n in (1, 2)]}))
    assert "2 edited" in run("element", "batch", walk, "edits.json")
    assert "- frames 1-2" in run("diff", walk, "1")
    assert json.loads(run("show", walk, "--json"))["frames"] == 28


@pytest.mark.parametrize(
    ("label", "right"),
    [
        ("walk:0-2", "Frames are numbered from 1"),
        ("walk:5-2", "begins at frame 5 and ends at 2"),
        ("jump:2", "such as jump:2-2"),
        ("jump:0", "NAME:FIRST-LAST"),
        ("walk:x-y", "NAME:FIRST-LAST"),
        ("walk:1-", "NAME:FIRST-LAST"),
        ("walk:", "NAME:FIRST-LAST"),
        (":1-2", "NAME:FIRST-LAST"),
        ("walk:29-31", "not in a document of 30 frames"),
    ],
)
def test_a_label_that_is_none_is_refused(run: Run, walk: str, label: str, right: str) -> None:
    before = run("labels", "list", walk, "--json")
    assert right in run("label", walk, label, code=1)
    assert run("labels", "list", walk, "--json") == before
    if "29" not in label:
        assert right in run("import", "walk.bvh", "--again", "--label", label, code=1)


def test_names_may_hold_a_colon_where_frames_follow(run: Run, walk: str) -> None:
    run("label", walk, "kim:walk:3-4", "turn : 5-6")
    items = json.loads(run("labels", "list", walk, "--json"))["items"]
    assert [(item["name"], item["first"], item["last"]) for item in items][1:] == [("kim:walk", 3, 4), ("turn", 5, 6)]


def test_a_range_to_compose_is_no_xpath_expression(run: Run, walk: str) -> None:
    assert "is not ID:FIRST-LAST" in run("compose", f"{walk}:5", "--name", "part", code=2)


def test_names_that_a_project_agrees_on(run: Run) -> None:
    assert "version 0" in run("project", "vocabulary", "default")
    said = run("project", "vocabulary", "default", "walk=on both feet", "turn", "--colour", "turn=3")
    assert "version 1" in said
    run("project", "vocabulary", "default", "turn=on the spot", "hop", "--remove", "walk")
    items = json.loads(run("project", "vocabulary", "default", "--json"))["items"]
    assert items == [{"name": "turn", "description": "on the spot", "colour": 3}, {"name": "hop", "description": ""}]
    assert "NAME=0..7" in run("project", "vocabulary", "default", "--colour", "hop=8", code=2)
    assert "version 0" not in run("project", "vocabulary", "default")
    run("project", "vocabulary", "default", "--remove", "turn", "--remove", "hop")
    assert "version 0" in run("project", "vocabulary", "default")


def test_names_of_joints(run: Run) -> None:
    Path("walk.bvh").write_bytes(bvh(5, names=("Hüfte", "Wirbel", "LeftUpLeg")))
    Path("run.bvh").write_bytes(bvh(7, names=("Hüfte", "Wirbel", "LeftUpLeg")))
    walk = json.loads(run("import", "walk.bvh", "--json"))["documents"][0]["id"]
    run("import", "run.bvh")
    assert "version 0" in run("mapping", "aliases")
    assert "version 1" in run("mapping", "alias", "Hüfte=Root", "Wirbel=waist")
    assert "version 2" in run("mapping", "alias", "wirbel=torso7", "Kopf=Head", "--remove", "hüfte")
    items = json.loads(run("mapping", "aliases", "--json"))["items"]
    assert [(item["source"], item["name"]) for item in items] == [("wirbel", "torso7"), ("Kopf", "Head")]
    told = run("names", "apply", "--project", "default", "--dry-run")
    assert "2 documents, such as" in told
    assert told.count("Wirbel: Wirbel -> torso7") == 1
    assert "2 of 2 documents would be changed" in told
    assert "Wirbel: Wirbel -> torso7" in run("names", "apply", walk)
    assert "0 of 1 documents were changed" in run("names", "apply", walk)
    assert "torso7" in run("show", walk)
    run("undo", walk)
    assert "torso7" not in run("show", walk)
    run("mapping", "alias", "--remove", "wirbel", "--remove", "kopf")
    assert "version 0" in run("mapping", "aliases")
    assert "NAME=JOINT" in run("mapping", "alias", code=2)
    assert "0 of 2 documents would be changed" in run("names", "apply", "--dry-run")
    assert "--project" in run("names", "apply", walk, "--project", "default", code=2)


HEAP = """HIERARCHY
ROOT Hips
{
OFFSET 0 0 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT Head
{
OFFSET 0 0 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
End Site
{
OFFSET 0 10 0
}
}
%s}
MOTION
"""
LEGS = "".join(
    f"JOINT {side}UpLeg\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    f"JOINT {side}Foot\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    "End Site\n{\nOFFSET 0 0 10\n}\n}\n}\n"
    for side in ("Left", "Right")
)


def heap(legs: bool) -> bytes:
    """A rig whose offsets come with the motion; the head nods."""
    rows = []
    for frame in range(60):
        row = f"0 90 0 0 0 0 0 60 0 0 {min(frame, 40)} 0"
        rows.append(row + (" 9 -5 0 0 0 0 0 -80 0 0 0 0 -9 -5 0 0 0 0 0 -80 0 0 0 0" if legs else ""))
    text = HEAP % (LEGS if legs else "") + "Frames: 60\nFrame Time: 0.0166667\n" + "\n".join(rows) + "\n"
    return text.encode()


def test_movements_of_rigs_that_lie_in_a_heap_at_rest(run: Run) -> None:
    found = {}
    for name, legs in (("sided", True), ("bare", False)):
        Path(f"{name}.bvh").write_bytes(heap(legs))
        found[name] = json.loads(run("import", f"{name}.bvh", "--json"))["documents"][0]["id"]
    assert "head-flexion" in run("labels", "suggest", found["sided"], "--kind", "movements")
    refused = run("labels", "suggest", found["bare"], "--kind", "movements", code=1)
    assert "nothing tells left from right" in refused
    assert "--facing" in refused
    assert "head-flexion" in run("labels", "suggest", found["bare"], "--kind", "movements", "--facing", "z")
    assert "head-extension" in run("labels", "suggest", found["bare"], "--kind", "movements", "--facing=-Z")


def test_what_files_do_not_say_is_stated(run: Run) -> None:
    Path("leg.asf").write_bytes(ASF)
    Path("leg.amc").write_bytes(amc(30))
    leg = json.loads(run("import", "leg.asf", "leg.amc", "--json"))["documents"][0]["id"]
    assert "0 suggested" in run("labels", "suggest", leg)
    refused = run("labels", "suggest", leg, "--kind", "movements", code=1)
    assert f"mcml set {leg} --frame-time" in refused
    assert "revision 2" in run("set", leg, "--frame-time", "0.0083333", "--unit", "inch", "-m", "as CMU records")
    assert "as CMU records" in run("history", leg)
    shown = json.loads(run("show", leg, "--json"))
    assert shown["seconds_per_frame"] == 0.0083333
    run("set", leg, "--up", "Y", "--revision", "2")
    run("rename", leg, "left leg")
    assert json.loads(run("show", "left leg", "--json"))["up"] == "Y"
    assert "say what" in run("set", leg, code=2)
    assert "seconds" in run("set", leg, "--frame-time", "x", code=1).lower()


def test_labels(run: Run, walk: str) -> None:
    run("label", walk, "hop:5-9")
    first, hop = (item["id"] for item in json.loads(run("labels", "list", walk, "--json"))["items"])
    run("labels", "change", walk, f"{hop}", "--name", "leap", "--last", "12")
    run("labels", "change", walk, f"{first}", "--split", "11")
    listed = run("labels", "list", walk)
    assert [line.split()[1:] for line in listed.splitlines()[1:]] == [
        ["1", "10", "walk"],
        ["5", "12", "leap"],
        ["11", "20", "walk"],
    ]
    assert "1 changed" in run("labels", "query", "stroll", "//frame[motion_name='walk']", "--instead-of", "walk")
    assert "walk" not in run("labels", "list", walk)
    assert run("xpath", "count(//frame[motion_name='stroll'])").strip() == "20"
    leap = json.loads(run("labels", "list", walk, "--name", "leap", "--json"))["items"][0]["id"]
    run("labels", "delete", walk, f"{leap}")
    assert "leap" not in run("labels", "list", walk)
    assert "say what: --name" in run("labels", "change", walk, "1", code=2)


def test_frames(run: Run, walk: str) -> None:
    bone = json.loads(run("show", walk, "--json"))["bones"][1]["name"]
    run("frames", walk, "adjust", "1-5", "--channel", "Rx", "--factor", "0", "--offset", "7", "--bone", bone)
    assert [float(run("element", "get", walk, f"//frame[{n}]/frame_bone[2]/@Rx")) == 7 for n in (1, 5, 6)] == [1, 1, 0]
    run("frames", walk, "smooth", "3-9", "--seconds", "0.1")
    assert "15 frames" in run("frames", walk, "keep", "1-15")
    assert "18 frames" in run("frames", walk, "insert", "1-3", "--to", "16")
    run("frames", walk, "reverse", "2-4")
    run("frames", walk, "resample", "--rate", "60")
    curve = f"{bone}.Rx"
    shown = run("frames", walk, "adjust", "1-5", "--channel", "Rx", "--factor", "0", "--offset", "9", "--dry-run",
                "--column", curve, "--quantity", f"height:{bone}")  # fmt: skip
    (row,) = (line for line in shown.splitlines() if line.startswith(curve))
    assert row.endswith("9 to 9")
    assert f"height:{bone}" in shown
    assert "Add dry_run" in run("frames", walk, "unroll", "--column", curve, code=1)
    assert "needs FIRST-LAST" in run("frames", walk, "smooth", code=2)
    assert "no use for rate" in run("frames", walk, "delete", "1", "--rate", "3", code=2)
    assert "not in a document" in run("frames", walk, "delete", "1-99999", code=1)


@pytest.mark.slow
def test_bodies(run: Run, tmp_path: Path) -> None:
    for height in (160, 184):
        clip = body.clip(f"walk_{height}", float(height), *body.walk(float(height), 1.0, 1.0, 6.0))
        Path(f"walk_{height}.bvh").write_bytes(b"".join(FORMATS["bvh"].write(clip, "bvh")))
    done = json.loads(run("import", "walk_160.bvh", "walk_184.bvh", "--json"))["documents"]
    small, large = (item["id"] for item in done)
    assert "would make" in run("retarget", small, large, "--preview")
    assert "version 1" in run("mapping", "save", "mine", "--suggest", small, large, "--joint", "left_hand=right_hand")
    assert "left_hand -> right_hand" in run("mapping", "show", "mine")
    assert "mine" in run("mapping", "list")
    made = json.loads(run("retarget", small, large, "--mapping", "mine", "--project", "default", "--json"))
    assert made["frames"] == 60
    many = run("retarget", large, "--xpath", "//frame[60]", "--all-of", "default", "--preview")
    assert "2 made, 0 failed" in many
    several = ("--all-of", "default", "--preview", "--travel-scale", "1", "--keep-hands")
    assert "wrote" in run("retarget", large, *several, "--table", "table.csv")
    lines = Path("table.csv").read_text().splitlines()
    assert lines[0].startswith("name,source,document,limbs (deg)")
    assert len(lines) == 3
    assert "a table is of a selection" in run("retarget", small, large, "--table", "table.csv", code=2)
    assert "states no limits" in run("retarget", small, large, "--file-limits", "--preview", code=1)
    for name in ("a/b", "a?b", "50 % #1"):
        assert f"{name}  version 1" in run("mapping", "save", name, "--joint", "left_hand=right_hand")
        assert f"{name}  version 1" in run("mapping", "show", name)
        run("mapping", "delete", name)
    run("frames", small, "mirror", "1-60")
    run("mapping", "delete", "mine")
    assert "no mapping" in run("mapping", "show", "mine", code=1)
    assert "name the motion" in run("retarget", large, code=2)
    assert "upperarm_twist_01_l" in run("retarget", small, "--to", "unreal5", "--preview")
    assert "name the motion" in run("retarget", small, large, "--to", "unreal5", code=2)
    assert "metahuman" in run("retarget", small, "--to", "unreal", code=2)
    for words in (
        ("retarget", small, large, "--travel-scale=-1"), ("compose", small, "--style", "jump"),
        ("frames", small, "smooth", "1-10", "--seconds=-1"),
        ("follow", "0,0", "4,0", "--speed=-1", "--all-of", "default"),
    ):  # fmt: skip
        assert "should be" in " ".join(run(*words, code=2).split())
    assert "Blender Rigify" in run("rigs")
    composed = run("compose", f"{small}:1-20", f"{large}:5-30", "--name", "both")
    assert "made  both" in composed
    assert "labels" not in run("labels", "suggest", small, "--accept")
    assert "movements named" in run("import", "walk_160.bvh", "--again", "--movements", "0.5")
    assert run("split", small, "11", "31").count("  walk_160 ") == 3
    run("labels", "export", "labels.csv")
    assert "0 changed" in run("labels", "import", "labels.csv")


def test_notes_of_an_edit_are_told(run: Run, walk: str) -> None:
    told = run("frames", walk, "unroll", "--dry-run")
    assert "revision 1" in told
    assert "rotations have other angles" in told


def test_proposals(run: Run, walk: str) -> None:
    made = json.loads(run("frames", walk, "smooth", "2-20", "--propose", "-m", "calmer", "--json"))
    assert (made["number"], made["summary"], made["revision"]) == (1, "smooth 2-20", 1)
    assert "smooth 2-20" in run("proposal", "list", walk, "--state", "pending")
    run("comment", "add", walk, "here?", "--first", "3", "--proposal", "1")
    assert json.loads(run("proposal", "show", walk, "1", "--json"))["comments"] == 1
    assert json.loads(run("proposal", "preview", walk, "1", "--json"))["kept"] == [
        {"before": 1, "after": 1, "count": 30}
    ]
    Path("named.json").write_text(json.dumps({"changes": {"document": {"description": "a walk"}}}))
    assert json.loads(run("proposal", "create", walk, "named.json", "--json"))["number"] == 2
    assert "requires a review" in run("project", "review", "default", "--required")
    assert "need a review" in run("frames", walk, "delete", "1-2", code=1)
    assert "your own" in run("proposal", "approve", walk, "1", code=1)
    assert "no approval by another" in run("proposal", "apply", walk, "1", code=1)
    assert "does not require" in run("project", "review", "default", "--optional")
    assert json.loads(run("proposal", "approve", walk, "1", "--json"))["state"] == "approved"
    assert json.loads(run("proposal", "apply", walk, "1", "--json"))["applied"] == 2
    assert json.loads(run("proposal", "rebase", walk, "2", "--json"))["revision"] == 2
    assert json.loads(run("proposal", "close", walk, "2", "--json"))["state"] == "closed"
    assert "calmer (proposal 1 by" in run("history", walk)


def test_a_standing_trial_is_shown_and_given_to_walks(run: Run) -> None:
    Path("static.c3d").write_bytes(gait_file(stand(), LENGTHS))
    Path("walk.c3d").write_bytes(gait_file(markers_of_walk(poses=WALKING), LENGTHS))
    run("import", "static.c3d", "walk.c3d")
    shown = run("standing-trial", "static")
    assert "LThighRotation" in shown
    assert "medial knee marker" in shown
    assert "note: a standing trial" in shown
    assert "walk" in run("standing-trial", "static", "walk", "--foot", "flat")
    properties = json.loads(run("show", "walk", "--json"))["properties"]
    assert "gait standing trial" in [item["name"] for item in properties]
    assert "no standing trial" in run("standing-trial", "walk", code=1)
