"""Tools of the clip page in a real browser: bones pulled in the viewer, clips compared, frames and elements put in."""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.builders import FACE
from tests.laboratory.walkers import Gait, make_c3d, make_steps, true_events
from tests.odd_documents import ODD
from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_editing import expect_other_picture
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door

MIDDLE_OF = """token => {
    const canvas = document.querySelector(".stage-overlay");
    const hex = getComputedStyle(document.documentElement).getPropertyValue(token).trim();
    const wanted = [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));
    const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const box = canvas.getBoundingClientRect();
    let [x, y, count] = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
        if (data[at + 3] < 200 || wanted.some((one, part) => Math.abs(one - data[at + part]) > 6)) continue;
        x += (at / 4) % width;
        y += Math.floor(at / 4 / width);
        count++;
    }
    return count && [box.left + (x / count) * box.width / width, box.top + (y / count) * box.height / height];
}"""
"""Where on the page the pixels of a colour are, over the viewer."""


@pytest.mark.slow
def test_a_bone_is_pulled_in_the_viewer_and_typed_in_the_structure(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_low_leg&tab=structure")
    ready(page)
    page.get_by_role("button", name="axes", exact=True).click()
    page.wait_for_function(f"() => ({MIDDLE_OF})('--x')")
    x, y = page.evaluate(MIDDLE_OF, "--x")
    field = page.get_by_label("X", exact=True)
    expect(field).to_have_value("0")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y, steps=4)
    page.mouse.up()
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    expect(field).not_to_have_value("0")
    page.keyboard.press("Control+z")
    expect(field).to_have_value("0")
    before = page.locator(".stage").screenshot()
    length = page.get_by_label("Length")
    old = float(length.input_value())
    length.fill(str(old * 2))
    length.press("Enter")
    expect_other_picture(page, before)
    page.keyboard.press("Control+s")
    expect(page.get_by_text("Saved as revision 2")).to_be_visible()
    bones = studio.get(f"/documents/{uuid}/skeleton")["bones"]
    offset = next(bone["offset"] for bone in bones if bone["name"] == "left_low_leg")
    assert sum(part**2 for part in offset) ** 0.5 == pytest.approx(2 * old, rel=1e-4)


@pytest.mark.fuzz
def test_clips_are_compared_in_step_and_left(visit: Visit, studio: Served) -> None:
    one = studio.upload("one.bvh", walk(60), label="kick:31-60")
    two = studio.upload("two.bvh", walk(40, seed=3), label="kick:11-40", unit="cm")
    page = visit.open(f"/clips/{one}?f=40")
    ready(page)
    before = page.locator(".stage").screenshot()
    page.get_by_role("button", name="Compare", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="two").click()
    page.get_by_role("dialog").get_by_role("button", name="Close").click()
    compared = page.get_by_role("region", name="Compare")
    expect(compared.get_by_role("listitem")).to_have_text([re.compile("one.*120"), re.compile("two.*cm.*120")])
    expect_other_picture(page, before)
    before = page.locator(".stage").screenshot()
    compared.get_by_role("button", name="by label").click()
    expect_other_picture(page, before)
    compared.get_by_role("button", name="Overlaid").click()
    # The camera is kept there too, when it has come to rest.
    page.wait_for_url(re.compile(f"cmp={two}&(cam=[^&]*&)?cmpsync=span&cmpas=over"))
    page.reload()
    ready(page)
    expect(compared.get_by_role("listitem")).to_have_count(2)
    page.keyboard.press("Escape")
    expect(compared).to_have_count(0)
    page.wait_for_url(lambda url: "cmp" not in url)


@pytest.mark.fuzz
def test_edges_snap_and_spans_are_split_by_menu(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(600), label="kick:101-200")
    page = visit.open(f"/clips/{uuid}?f=401")
    ready(page)
    lane = page.get_by_role("list", name="labels")
    box = lane.bounding_box()
    spans = lane.get_by_role("listitem").get_by_role("button")

    def pull(start: int, end: int, key: str = "") -> None:
        """Draw from one frame's edge to 5 pixels beside another's."""
        x, wide = box["x"], box["width"] / 600
        page.mouse.move(x + start * wide, box["y"] + 12)
        page.mouse.down()
        page.mouse.move(x + end * wide - 20, box["y"] + 12)
        if key:
            page.keyboard.down(key)
        page.mouse.move(x + end * wide - 5, box["y"] + 12)
        expect(page.locator(".snap-line")).to_have_count(0 if key else 1)
        page.mouse.up()
        if key:
            page.keyboard.up(key)

    pull(198, 401)
    expect(spans).to_have_accessible_name("kick, 101–401")
    page.keyboard.press("Control+z")
    pull(198, 401, "Alt")
    expect(spans).not_to_have_accessible_name("kick, 101–401")
    page.keyboard.press("Control+z")
    expect(spans).to_have_accessible_name("kick, 101–200")
    frame = page.get_by_label("Frame", exact=True)
    frame.fill("150")
    frame.press("Enter")
    spans.press("F2")
    page.get_by_role("form", name="Label").get_by_role("button", name="Split").click()
    expect(spans).to_have_count(2)
    expect(spans.last).to_have_accessible_name("kick, 150–200")


@pytest.mark.slow
def test_elements_are_added_and_deleted_in_the_tree(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(), property="age=23")
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    tree = page.get_by_role("tree", name="Tree")

    def row(text: str) -> Any:
        return tree.get_by_role("treeitem").filter(has_text=re.compile(f"^{text}"))

    row("header").click()
    page.keyboard.press("ArrowRight")
    expect(row("property")).to_be_visible()
    row("header").click()
    page.keyboard.press("Insert")
    form = page.get_by_role("dialog", name="Add to header")
    form.get_by_label("Element").select_option("property")
    form.get_by_label("name", exact=True).fill("shoe")
    expect(form.get_by_role("button", name="Add", exact=True)).to_be_disabled()
    form.get_by_label("value", exact=True).fill("left & right")
    form.get_by_role("button", name="Add", exact=True).click()
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    expect(page.get_by_role("button", name="Undo new property")).to_be_visible()
    row("property").click(position={"x": 75, "y": 12})
    page.keyboard.press("Delete")
    expect(page.get_by_text("Draft: 2 changes")).to_be_visible()
    expect(tree.locator(".gone").first).to_contain_text("property")
    row("skeleton").click()
    page.keyboard.press("Delete")
    expect(page.get_by_text("Delete its frame_bone elements first.")).to_be_visible()
    expect(page.get_by_text("Draft: 2 changes")).to_be_visible()
    page.keyboard.press("Control+s")
    expect(page.get_by_text("Saved as revision 2")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["properties"] == [{"name": "shoe", "value": "left & right", "unit": ""}]


@pytest.mark.slow
def test_frames_are_taken_out_held_and_taken_back(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    page = visit.open(f"/clips/{uuid}?f=5&in=11&out=20&sel=left_up_leg&tab=graph")
    ready(page)

    def choose(item: str) -> None:
        page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
        page.get_by_role("menuitem", name=item).click()

    field = page.get_by_role("group", name="Value at frame 5").get_by_label("Rx")
    expect(field).not_to_have_value("")
    field.fill("1.5")
    field.press("Enter")
    choose("Delete frames 11–20")
    expect(page.get_by_text("Save the draft first")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["frames"] == 60
    page.get_by_role("button", name="Discard").click()
    choose("Delete frames 11–20")
    expect(page.get_by_text("of 50", exact=True)).to_be_visible()
    choose("Hold frame 5")
    page.get_by_label("for more frames").fill("7")
    page.keyboard.press("Enter")
    expect(page.get_by_text("of 57", exact=True)).to_be_visible()
    page.get_by_role("status").filter(has_text="Now 57 frames").get_by_role("button", name="Undo").click()
    expect(page.get_by_text("of 50", exact=True)).to_be_visible()


def test_revisions_are_flipped_and_two_of_them_compared(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    with studio.client() as client:
        for revision, value in ((1, 70.0), (2, -70.0)):
            edit = {"frames": [{"first": 20, "columns": ["left_low_leg.Rx"], "values": [[value]]}]}
            client.post(f"/documents/{uuid}/changes", json=edit, headers={"if-match": str(revision)}).raise_for_status()
    page = visit.open(f"/clips/{uuid}?f=20&tab=history")
    ready(page)
    page.get_by_role("button", name="Show as ghost").last.click()
    told = page.get_by_role("button", name=re.compile(r"^left_foot: .* cm at frame 20$"))
    expect(told).to_be_visible()
    before = page.locator(".stage").screenshot()
    page.keyboard.down("c")
    expect_other_picture(page, before)
    flipped = page.locator(".stage").screenshot()
    page.keyboard.up("c")
    expect_other_picture(page, flipped)
    page.get_by_label("Select revision 1").check()
    page.get_by_label("Select revision 2").check()
    expect(page.get_by_role("region", name="Difference")).to_contain_text("Difference of revisions 1 and 2")
    expect(told).to_be_visible()
    page.get_by_label("Frame", exact=True).fill("1")
    page.get_by_label("Frame", exact=True).press("Enter")
    told.click()
    expect(page.get_by_label("Frame", exact=True)).to_have_value("20")


def test_blend_shapes_are_bars_and_curves(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("face.mcml", FACE)
    page = visit.open(f"/clips/{uuid}?f=2&tab=graph")
    ready(page)
    shapes = page.get_by_role("region", name="Blend shapes")
    jaw = shapes.get_by_role("button", name="JawOpen")
    expect(jaw).to_contain_text("0.75")
    expect(shapes.get_by_role("button", name="EyeBlinkLeft")).to_contain_text("1.05")
    jaw.click()
    expect(page.get_by_label("weight", exact=True)).to_have_value("0.75")
    page.keyboard.press("ArrowRight")
    expect(jaw).to_contain_text("–")
    expect(jaw).to_have_attribute("aria-pressed", "true")


def find_arrows(page: Any) -> tuple[float, float] | None:
    """(highest, lowest) row of the pixels of arrows in the viewer, None without any."""
    text = page.evaluate("() => getComputedStyle(document.documentElement).getPropertyValue('--bad').trim()")
    ink = np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)])
    picture = np.asarray(Image.open(io.BytesIO(page.locator(".stage").screenshot())).convert("RGB")).astype(int)
    rows = np.flatnonzero((np.abs(picture - ink).max(axis=2) <= 3).any(axis=1))
    return (float(rows[0]), float(rows[-1])) if len(rows) else None


def wait_for_arrows(page: Any, *, shown: bool) -> tuple[float, float] | None:
    for _ in range(100):
        arrows = find_arrows(page)
        if (arrows is not None) == shown:
            return arrows
        page.wait_for_timeout(50)
    raise AssertionError(f"arrows are {'hidden' if shown else 'shown'}")


def test_forces_are_arrows_in_step_with_the_frames(visit: Visit, studio: Served) -> None:
    gait = Gait(seconds=3)
    strike = next(at for at in true_events(gait)["left", "strike"] if at > 1)
    uuid = studio.upload("walk.c3d", make_c3d(gait, steps=make_steps(gait, [("left", strike)])))
    early, middle = (round((strike + share * gait.duty * gait.stride_time) * gait.rate) for share in (0.1, 0.5))
    page = visit.open(f"/clips/{uuid}?f={middle}")
    ready(page)
    forces = page.get_by_role("button", name="forces", exact=True)
    expect(forces).to_have_attribute("aria-pressed", "true")
    expect(forces).to_have_attribute("title", re.compile("1 m long for 1,000 N"))
    high, low = wait_for_arrows(page, shown=True) or (0.0, 0.0)
    frame = page.get_by_label("Frame", exact=True)

    def go(to: int) -> None:
        frame.fill(str(to))
        frame.press("Enter")

    go(round(strike * gait.rate) - 10)
    wait_for_arrows(page, shown=False)
    go(early)
    early_high, early_low = wait_for_arrows(page, shown=True) or (0.0, 0.0)
    assert early_low - early_high < 0.7 * (low - high), "the force is small then"
    forces.click()
    wait_for_arrows(page, shown=False)
    other = studio.upload("kick.bvh", walk())
    page.goto(f"{studio.url}/clips/{other}")
    ready(page)
    expect(page.get_by_role("button", name="axes", exact=True)).to_be_visible()
    expect(forces).to_have_count(0)


@pytest.mark.slow
def test_spikes_are_previewed_removed_and_taken_back(visit: Visit, studio: Served) -> None:
    lines = walk(60).decode().splitlines(keepends=True)
    first = next(place for place, one in enumerate(lines) if one.startswith("Frame Time")) + 1
    numbers = lines[first + 30].split()
    lines[first + 30] = " ".join([str(float(numbers[0]) + 500), *numbers[1:]]) + "\n"
    uuid = studio.upload("spiky.bvh", "".join(lines).encode())
    page = visit.open(f"/clips/{uuid}?f=5")
    ready(page)
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    page.get_by_role("menuitem", name="Repair frames").click()
    dialog = page.get_by_role("dialog", name="Repair frames")
    expect(dialog.get_by_text("no gaps between known samples")).to_be_visible()
    dialog.get_by_label("Edit").select_option("Remove spikes")
    notes = dialog.get_by_role("status", name="Preview")
    expect(notes).to_contain_text("Root 1")
    expect(dialog.get_by_text("Frames 1–60")).to_be_visible()
    # The curve of the spike, before and after, as the service gives both.
    curve = dialog.get_by_label("Curve", exact=True)
    expect(curve).to_have_value("column=left_up_leg.Rx")
    curve.select_option("column=Root.Tx")
    expect(dialog.get_by_role("img", name="Root.Tx before and after")).to_be_visible()
    dialog.get_by_text("As table").click()
    row = dialog.get_by_role("row").filter(has=page.get_by_role("cell", name="31", exact=True))
    before, after = (float(text.replace(",", "")) for text in row.get_by_role("cell").all_inner_texts()[1:])
    assert before - after == pytest.approx(500, abs=5)
    # Less strict, nothing is a spike: the curve follows the parameters.
    dialog.get_by_label("Deviations").fill("1000")
    dialog.get_by_label("Deviations").blur()
    expect(notes).to_contain_text("no spikes")
    expect(row.get_by_role("cell").nth(2)).to_have_text(row.get_by_role("cell").nth(1).inner_text())
    dialog.get_by_label("Deviations").fill("6")
    dialog.get_by_label("Deviations").blur()
    expect(notes).to_contain_text("Root 1")
    curve.select_option("quantity=height:Root")
    expect(dialog.get_by_text("height:Root has no values in these frames.")).to_be_visible()
    curve.select_option("column=left_low_leg.Ry")
    expect(dialog.get_by_role("img", name="left_low_leg.Ry before and after")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["revision"] == 1
    revision = studio.get(f"/documents/{uuid}")["revision"]
    dialog.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("Now 60 frames; spikes replaced")).to_be_visible()
    hide = page.get_by_role("button", name="Hide marks of replaced samples")
    expect(hide).to_be_visible()
    expect(hide).to_have_attribute("title", re.compile("frame range"))
    spiky = studio.get(f"/documents/{uuid}/frames", revision=revision, first=31, last=31)["items"][0]["values"]
    mended = studio.get(f"/documents/{uuid}/frames", first=31, last=31)["items"][0]["values"]
    root = next(iter(spiky))
    assert spiky[root]["Tx"] - mended[root]["Tx"] == pytest.approx(500, abs=5)
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("revision 3", exact=True)).to_be_visible()
    expect(hide).to_have_count(0)
    assert studio.get(f"/documents/{uuid}/frames", first=31, last=31)["items"][0]["values"] == spiky


def test_a_frame_that_shows_nothing_leads_to_one_that_does(visit: Visit, studio: Served) -> None:
    ((name, content),) = ODD["seen late"].items()
    page = visit.open(f"/clips/{studio.upload(name, content)}")
    ready(page)
    note = page.get_by_text("No marker or joint is known in this frame.")
    expect(note).to_be_visible()
    page.get_by_role("button", name="Go to frame 41").click()
    expect(note).to_have_count(0)
    expect(page.get_by_label("Frame", exact=True)).to_have_value("41")
