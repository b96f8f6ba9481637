"""The add-on in a real Blender, against a real server."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.builders import ASF, HTR, TRC, amc, bvh, c3d_file
from tests.integrations.addon import Blender, Served, away, mixed

NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot")


def test_documents_are_listed_and_imported(repository: Served, blender: Blender) -> None:
    document = repository.upload({"mixed.bvh": mixed()})
    for number in range(54):
        repository.upload({f"clip{number}.bvh": bvh(3, seed=number)})
    listed, following, back, searched, imported, found, rate, figures, again, one = blender(
        repository,
        ("list_documents",),
        ("list_documents", "", "next"),
        ("list_documents", "", "previous"),
        ("list_documents", "mixed"),
        ("import_clip", 0),
        ("positions",),
        ("rate",),
        ("figures",),
        ("import_clip", 0),
        ("figures",),
    )
    assert (len(listed["names"]), listed["place"]) == (50, "1-50 of 55")
    assert (len(following["names"]), following["place"]) == (5, "51-55 of 55")
    assert back == listed
    assert (searched["names"], searched["place"]) == (["mixed"], "1-1 of 1")
    assert imported == again == "FINISHED"
    assert figures == one == ["mixed"]
    assert rate == pytest.approx(40)
    distance = away(repository, document, found)
    print(f"{distance:.2g}")
    assert distance < 1e-5


@pytest.mark.parametrize("unit", [{}, {"unit": "in", "up": "Z"}, {"unit": "cm", "up": "X"}])
def test_unit_and_up_axis_are_those_of_the_figure(repository: Served, blender: Blender, unit: dict[str, str]) -> None:
    document = repository.upload({"mixed.bvh": mixed()})
    with repository.client() as client:
        client.patch(f"/documents/{document}", json=unit, headers={"if-match": "*"}).raise_for_status()
    _, _, found = blender(repository, ("list_documents",), ("import_clip", 0), ("positions",))
    assert away(repository, document, found) < 1e-5


OTHERS = {
    "asf": {"leg.asf": ASF, "leg.amc": amc(5)},
    "htr": {"arm.htr": HTR},
    "trc": {"hand.trc": TRC},
    "c3d": {"points.c3d": c3d_file()},
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_conventions_are_imported_and_not_sent(repository: Served, blender: Blender, name: str) -> None:
    document = repository.upload(OTHERS[name])
    _, imported, found, refused = blender(
        repository, ("list_documents",), ("import_clip", 0), ("positions",), ("send",)
    )
    assert imported == "FINISHED"
    assert away(repository, document, found) < 1e-5
    assert "Only documents whose joints turn as those of BVH" in refused
    assert repository.get(f"/documents/{document}")["revision"] == 1


REAL = ("bvh/bandai/dataset-1_bow_old_001.bvh", "htr/xbot_walking.HTR", "c3d/body/mocap36.c3d")


@pytest.mark.parametrize("name", REAL, ids=lambda name: name.partition("/")[0])
def test_real_clips_are_imported(repository: Served, shared: Path, blender: Blender, name: str) -> None:
    document = repository.upload({Path(name).name: (shared / name).read_bytes()})
    _, imported, found, _ = blender(repository, ("list_documents",), ("import_clip", 0), ("positions",), ("send",))
    assert imported == "FINISHED"
    distance = away(repository, document, found)
    print(f"{distance:.2g}")
    assert distance < 1e-5
    assert repository.get(f"/documents/{document}")["revision"] == 1, "nothing was edited"


def test_runs_become_actions(repository: Served, blender: Blender) -> None:
    first = repository.upload({"a.bvh": bvh(30, names=NAMES)}, label=["walk:3-9", "walk:20-20"])
    repository.upload({"b.bvh": bvh(40, seed=1, names=NAMES)}, label=["walk:1-40"])
    runs, actions, figures, _, found, none, bones, wrong = blender(
        repository,
        ("import_runs", "//frame[motion_name='walk']"),
        ("actions",),
        ("figures",),
        ("use_action", "a 3-9"),
        ("positions",),
        ("import_runs", "count(//frame)"),
        ("import_runs", "//bone"),
        ("import_runs", "//frame["),
    )
    assert runs["runs"] == [["a", 3, 9], ["a", 20, 20], ["b", 1, 40]]
    assert actions == {"a 3-9": [1, 7, 7], "a 20-20": [1, 1, 1], "b": [1, 40, 40]}
    assert figures == ["a"]
    found = {name: rows[:7] for name, rows in found.items()}
    assert away(repository, first, found, first=3, last=9) < 1e-5
    assert "not a node set" in none["listed"]
    assert bones["runs"] == []
    assert bones["listed"].startswith("Error: ")
    assert wrong["listed"].startswith("Error: ")


def test_runs_are_those_that_were_listed(repository: Served, blender: Blender) -> None:
    document = repository.upload({"a.bvh": bvh(30, names=NAMES)}, label=["walk:12-19"])
    address = f"{repository.url}/api/v1/documents/{document}/frames"
    headers = {**repository.headers(), "if-match": "*", "content-type": "application/json"}
    cut = {"edits": [{"do": "delete", "first": 1, "last": 10}]}
    *_, imported, found, refused = blender(
        repository,
        ("import_runs", "//frame[motion_name='walk']"),
        ("request", "POST", address, cut, headers),
        ("import_listed_runs",),
        ("positions",),
        ("send",),
    )
    assert imported == "FINISHED"
    assert away(repository, document, found, first=12, last=19, revision=1) < 1e-5
    assert "Somebody changed these frames of a since revision 1; it is at revision 2 now." in refused


@pytest.mark.parametrize("translation", ["absolute", "relative"])
def test_edits_go_back_as_one_revision(repository: Served, blender: Blender, translation: str) -> None:
    document = repository.upload({"mixed.bvh": mixed()}, label=["walk:11-30"], translation=translation)
    said = repository.get(f"/documents/{document}/skeleton")["bones"][0]["translation"]
    assert said == translation
    before = repository.numbers(document)
    columns = repository.get(f"/documents/{document}/skeleton")["columns"]
    names = [text.rpartition(".")[0] for text in columns]
    spine, neck = names[6], names[9]
    _, found, unchanged, *_, sent, revision, again = blender(
        repository,
        ("import_runs", "//frame[motion_name='walk']"),
        ("positions",),
        ("send",),
        ("edit", spine, "rotation_euler", 1, [3, 5], 0.5),
        ("edit", neck, "location", 2, [5], 2.25),
        ("edit", "Root", "location", 0, [20], -1.5),
        ("send",),
        ("revision",),
        ("send",),
    )
    assert unchanged == sent == again == "FINISHED"
    assert away(repository, document, found, first=11, last=30, revision=1) < 1e-5
    assert revision == 2
    after = repository.numbers(document)
    wanted = before.copy()
    wanted[[12, 14], columns.index(f"{spine}.Ry")] += np.degrees(0.5)
    wanted[14, columns.index(f"{neck}.Tz")] += 2.25
    wanted[29, columns.index("Root.Tx")] -= 1.5
    changed = wanted != before
    assert changed.sum() == 4
    np.testing.assert_array_equal(after[~changed], before[~changed])
    np.testing.assert_allclose(after[changed], wanted[changed], atol=2e-5)
    history = repository.get(f"/documents/{document}/revisions")["items"]
    assert [item["number"] for item in history] == [2, 1]
    assert history[0]["message"].startswith("edited in Blender: ")
    assert repository.get(f"/documents/{document}")["revision"] == 2


def test_any_names_go_there_and_back(repository: Served, blender: Blender) -> None:
    names = ('a"b]', "back\\slash", "é" * 80, "é" * 80 + "b", "Hips.001")
    document = repository.upload({"odd.bvh": bvh(5, names=names)})
    before = repository.numbers(document)
    columns = repository.get(f"/documents/{document}/skeleton")["columns"]
    *_, sent = blender(
        repository,
        ("list_documents",),
        ("import_clip", 0),
        *(("edit_nth", number, "rotation_euler", 0, [2], 0.125 * number) for number in range(1, 5)),
        ("send",),
    )
    assert sent == "FINISHED"
    wanted = before.copy()
    turned = [place for place, text in enumerate(columns) if text.endswith(".Rx")]
    wanted[1, turned] += np.degrees(0.125 * np.arange(5))
    np.testing.assert_allclose(repository.numbers(document), wanted, atol=2e-5)


def test_the_panel_shows_what_there_is(repository: Served, blender: Blender) -> None:
    repository.upload({"walk.bvh": bvh(24, names=NAMES)})
    _, shown = blender(repository, ("list_documents",), ("draw",))
    assert shown["operators"] == shown["known"]
    assert set(shown["known"]) == {"list", "import_clip", "list_runs", "import_runs", "send"}
    assert shown["lists"] == [1, 0]
    assert shown["shown"] == ["server", "token", "search", "xpath", "server", "token"]
    assert shown["texts"] == ["1-1 of 1", "walk", "24 · 0.2 s"]


@pytest.mark.parametrize("mode", ["QUATERNION", "XZY"])
def test_a_bone_may_turn_otherwise(repository: Served, blender: Blender, mode: str) -> None:
    document = repository.upload({"mixed.bvh": mixed()})
    before = repository.numbers(document)
    skeleton = repository.get(f"/documents/{document}/skeleton")
    spine = skeleton["bones"][1]["name"]
    *_, sent, _, found = blender(
        repository,
        ("list_documents",),
        ("import_clip", 0),
        ("to_mode", spine, mode),
        ("rename", spine, "back"),
        ("send",),
        ("rename", "back", spine),
        ("positions",),
    )
    assert sent == "FINISHED"
    after = repository.numbers(document)
    rows, places = np.nonzero(after != before)
    assert set(rows) == {1}
    assert {skeleton["columns"][place].rpartition(".")[0] for place in places} == {spine}
    assert away(repository, document, found) < 1e-5


def test_channels_without_a_curve_stay(repository: Served, blender: Blender) -> None:
    document = repository.upload({"mixed.bvh": mixed()})
    spine = repository.get(f"/documents/{document}/skeleton")["bones"][1]["name"]
    *_, sent, revision = blender(
        repository,
        ("list_documents",),
        ("import_clip", 0),
        ("delete_curves", spine),
        ("send",),
        ("revision",),
    )
    assert (sent, revision) == ("FINISHED", 1)


def test_what_the_document_cannot_hold_is_refused(repository: Served, blender: Blender) -> None:
    document = repository.upload({"mixed.bvh": mixed()})
    bones = repository.get(f"/documents/{document}/skeleton")["bones"]
    leg = next(bone["name"] for bone in bones if bone["channels"] == ["Rx"])
    start = (("list_documents",), ("import_clip", 0))
    for path, word in (("location", "moved"), ("rotation_euler", "turned"), ("scale", "scaled")):
        *_, said = blender(repository, *start, ("key", leg, path, 1, 4, 0.5), ("send",))
        assert f"{leg} is {word}" in said
        assert "Nothing was sent" in said
    assert repository.get(f"/documents/{document}")["revision"] == 1


def test_conflicts_are_told(repository: Served, blender: Blender) -> None:
    document = repository.upload({"walk.bvh": bvh(10, names=NAMES)})
    address = f"{repository.url}/api/v1/documents/{document}"
    headers = {**repository.headers(), "if-match": "*", "content-type": "application/json"}
    label = [{"name": "walk", "first": 1, "last": 3}]
    values = {"columns": ["Root.Rx"], "values": [[12.5]]}
    *_, first, revision, _, _, refused, _ = blender(
        repository,
        ("list_documents",),
        ("import_clip", 0),
        ("request", "POST", f"{address}/labels", label, headers),
        ("edit", "Root", "rotation_euler", 1, [2], 0.25),
        ("send",),
        ("revision",),
        ("request", "PUT", f"{address}/frames?first=7", values, headers),
        ("edit", "Root", "rotation_euler", 1, [2], 0.25),
        ("send",),
        ("revision",),
    )
    assert (first, revision) == ("FINISHED", 3), "a label is in nobody's way"
    assert "Somebody changed these frames of walk since revision 3; it is at revision 4" in refused
    assert "Import the clip again" in refused
    assert repository.get(f"/documents/{document}")["revision"] == 4


def test_wrong_tokens_and_servers_are_told(repository: Served, blender: Blender) -> None:
    repository.upload({"walk.bvh": bvh(3, names=NAMES)})
    _, wrong, _, nobody, _, nonsense, _, _, _, _, elsewhere = blender(
        repository,
        ("set_server", repository.url, "mcml_wrong"),
        ("list_documents",),
        ("set_server", "http://127.0.0.1:9", ""),
        ("list_documents",),
        ("set_server", "file:///etc/passwd", ""),
        ("list_documents",),
        ("set_server", f"{repository.url}/", repository.token),
        ("list_documents",),
        ("import_clip", 0),
        ("set_server", "http://127.0.0.1:9", repository.token),
        ("send",),
    )
    assert "Set the token in the preferences" in wrong["said"]
    assert "No answer from http://127.0.0.1:9" in nobody["said"]
    assert "must begin with http" in nonsense["said"]
    assert f"This action is from {repository.url}" in elsewhere
