"""The dance bench in the browser: beats corrected, a graph that is tried, dances made, heard in step, kept."""

from __future__ import annotations

import io
import re
import wave
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.settings import Settings
from tests.web.conftest import Served
from tests.web.test_pages import PICTURES, serious_faults

pytestmark = pytest.mark.usefixtures("lent_workers")

SAMPLED = """seconds => new Promise(done => {
  const found = [];
  const began = performance.now();
  const step = now => {
    const heard = window.mcmlDance.reading(now);
    const { perSecond, frame, led } = window.mcmlDance;
    if (heard !== null) found.push([heard, heard * perSecond, frame(), led(now) * perSecond]);
    if (now - began < seconds * 1000) requestAnimationFrame(step); else done(found);
  };
  requestAnimationFrame(step);
})"""


@pytest.fixture
def dances(open_studio: Served) -> list[str]:
    """Ids of three dances on one skeleton, by name."""
    clips = [dance_clip("groove", bars=8, seed=seed, name=f"groove {seed}").clip for seed in (1, 2, 3)]
    add_clips(open_studio.database, Settings(), "dances", clips, (), "")
    items = open_studio.get("/documents", project="dances", sort="name")["items"]
    return [str(one["id"]) for one in items]


@pytest.fixture
def bench(open_studio: Served, visit_of: Any, dances: list[str]) -> Any:
    """The page with their rows."""
    page = visit_of(open_studio).open("/dance?" + "&".join(f"doc={one}" for one in dances))
    expect(page.locator(".bench-row")).to_have_count(3, timeout=60_000)  # of an analysis
    return page


def bars_of(page: Any, name: str) -> Any:
    return page.get_by_role("article", name=name).locator("[data-bars]")


def make(page: Any, **fields: str) -> str:
    """Make a dance: the id of its result."""
    for label, value in fields.items():
        field = page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
    page.get_by_role("button", name="Create dance", exact=True).click()
    page.wait_for_url(re.compile(r"/dance/[0-9a-f-]{36}"))
    expect(page.get_by_role("button", name="Save…")).to_be_visible()
    return str(page.url.split("/dance/")[1].split("?")[0])


@pytest.mark.slow
def test_a_bench_is_opened_from_a_project(open_studio: Served, visit_of: Any, dances: list[str]) -> None:
    page = visit_of(open_studio).open("/dance")
    page.get_by_label("Project").select_option("dances")
    page.get_by_role("checkbox", name="groove 3").uncheck()
    page.get_by_role("button", name="Open clips").click()
    expect(page.locator(".bench-row")).to_have_count(2, timeout=60_000)  # of an analysis
    assert page.url.count("doc=") == 2
    page.get_by_role("button", name="Other clips").click()
    expect(page.get_by_role("button", name="Open clips")).to_be_visible()


@pytest.mark.slow
def test_beats_are_corrected_and_bars_follow(open_studio: Served, bench: Any) -> None:
    lane = bench.get_by_role("listbox", name="Beats of groove 1")
    expect(bars_of(bench, "groove 1")).to_have_attribute("data-bars", "8")
    beats = lane.get_by_role("option").count()
    lane.focus()
    for _ in range(3):
        lane.press("ArrowRight")
    lane.press("Delete")
    expect(lane.get_by_role("option")).to_have_count(beats - 1)
    expect(bars_of(bench, "groove 1")).to_have_attribute("data-bars", "7")
    expect(bars_of(bench, "groove 2")).to_have_attribute("data-bars", "8")
    bench.reload()
    expect(bars_of(bench, "groove 1")).to_have_attribute("data-bars", "7")
    expect(bench.get_by_role("button", name="Jobs")).to_have_count(0)
    # A dance of it leaves out the bar that is none.
    result = make(bench, Bars="4")
    wish = open_studio.get(f"/results/{result}")["parameters"]
    assert [len(one["beats"]) for one in wish["clips"]] == [beats - 1]
    assert wish["bars"] == 4


@pytest.mark.fuzz
def test_a_beat_is_dragged_added_and_all_of_it_undone(bench: Any) -> None:
    lane = bench.get_by_role("listbox", name="Beats of groove 2")
    first = lane.get_by_role("option").first
    expect(bars_of(bench, "groove 2")).to_have_attribute("data-bars", "8")
    before = lane.get_by_role("option").count()
    at = [float(text.split(",")[1].split()[0]) for text in lane.get_by_role("option").all_inner_texts()]
    box = lane.locator("canvas").bounding_box()
    seconds = 8 * 4 * 60 / 112
    scale = box["width"] / (seconds - 1 / 60)
    # Far from any minimum, with Alt: it lies where it was let go.
    bench.mouse.move(box["x"] + at[4] * scale, box["y"] + 9)
    bench.mouse.down()
    bench.keyboard.down("Alt")
    bench.mouse.move(box["x"] + (at[4] + 0.2) * scale, box["y"] + 9, steps=4)
    bench.mouse.up()
    bench.keyboard.up("Alt")
    moved = lane.get_by_role("option").nth(4)
    expect(moved).to_contain_text("by hand")
    assert float(moved.inner_text().split(",")[1].split()[0]) == pytest.approx(at[4] + 0.2, abs=2 / scale)
    expect(bars_of(bench, "groove 2")).not_to_have_attribute("data-bars", "8")
    # Without Alt it snaps back to the rest it was taken from.
    bench.mouse.move(box["x"] + (at[4] + 0.2) * scale, box["y"] + 9)
    bench.mouse.down()
    bench.mouse.move(box["x"] + (at[4] + 0.03) * scale, box["y"] + 9, steps=4)
    bench.mouse.up()
    expect(moved).not_to_contain_text(f"{at[4] + 0.2:.2f}")
    assert float(moved.inner_text().split(",")[1].split()[0]) == pytest.approx(at[4], abs=1 / 30)
    expect(bars_of(bench, "groove 2")).to_have_attribute("data-bars", "8")
    bench.mouse.dblclick(box["x"] + (at[7] + at[8]) / 2 * scale, box["y"] + 30)
    expect(lane.get_by_role("option")).to_have_count(before + 1)
    for _ in range(3):
        bench.keyboard.press("Control+z")
    expect(lane.get_by_role("option")).to_have_count(before)
    expect(moved).to_contain_text("detected")
    expect(first).to_contain_text("detected")
    bench.keyboard.press("Control+Shift+z")
    expect(moved).to_contain_text("by hand")


@pytest.mark.fuzz
def test_refused_minima_say_why_and_a_tempo_is_chosen(bench: Any) -> None:
    row = bench.get_by_role("article", name="groove 1")
    row.get_by_label("Beats: groove 1").select_option("tracked")
    lane = bench.get_by_role("listbox", name="Beats of groove 1")
    expect(lane.get_by_role("option").first).to_contain_text("tracked")
    lane.focus()
    bench.keyboard.press("Shift+B")
    expect(lane.get_by_role("option").first).to_contain_text("by hand")
    tempi = row.get_by_role("group", name="Tempo: groove 1").get_by_role("button")
    expect(tempi.first).to_have_attribute("aria-pressed", "true")
    tempi.nth(1).click()
    expect(tempi.nth(1)).to_have_attribute("aria-pressed", "true")


@pytest.mark.fuzz
def test_a_press_holds_though_other_tempi_are_found_meanwhile(bench: Any) -> None:
    row = bench.get_by_role("article", name="groove 1")
    tempi = row.get_by_role("group", name="Tempo: groove 1").get_by_role("button")
    chip = tempi.nth(2)
    expect(chip).to_be_visible()
    said = chip.inner_text()
    asked: list[Any] = []
    bench.route("**/analyses/beats", lambda one: asked.append(one), times=1)
    bench.get_by_role("listbox", name="Beats of groove 1").focus()
    bench.keyboard.press("Shift+B")
    bench.wait_for_selector(".bench-row.stale")
    place = chip.bounding_box()
    bench.mouse.move(place["x"] + place["width"] / 2, place["y"] + place["height"] / 2)
    bench.mouse.down()
    asked[0].continue_()
    expect(bench.locator(".bench-row.stale")).to_have_count(0)
    bench.mouse.up()
    pressed = row.get_by_role("button", name=said)
    expect(pressed).to_have_attribute("aria-pressed", "true")
    expect(bench.locator(".bench-row.stale")).to_have_count(0)
    expect(pressed).to_have_attribute("aria-pressed", "true")


@pytest.mark.fuzz
def test_a_tempo_that_was_chosen_can_be_changed_and_taken_back(bench: Any) -> None:
    row = bench.get_by_role("article", name="groove 1")
    tempi = row.get_by_role("group", name="Tempo: groove 1").get_by_role("button")
    expect(tempi.first).to_have_attribute("aria-pressed", "true")
    offered = tempi.all_inner_texts()
    for place in (1, 0):
        with bench.expect_response("**/results/*"):
            tempi.nth(place).click()
        expect(bench.locator(".bench-row.stale")).to_have_count(0)
        assert tempi.all_inner_texts() == offered
        expect(tempi.nth(place)).to_have_attribute("aria-pressed", "true")
    # A reload finds no rivals of a tempo that is given; it stands there itself.
    bench.reload()
    expect(tempi.filter(has_text=offered[0]).first).to_have_attribute("aria-pressed", "true")
    tempi.filter(has_text=offered[0]).first.click()
    expect(tempi).to_have_text(offered)


@pytest.mark.slow
def test_the_graph_is_drawn_tried_and_its_edges_play(open_studio: Served, bench: Any) -> None:
    bench.get_by_role("button", name="Build motion graph").click()
    bench.wait_for_selector(".bench-canvas[data-laid]")
    said = bench.locator(".bench-graph").get_by_role("status")
    before = said.inner_text()
    slider = bench.get_by_label("Threshold")
    slider.focus()
    slider.press("End")
    expect(said).not_to_have_text(before)
    expect(said).to_contain_text("1 components")
    bench.wait_for_url("**near=*")
    # By the pointer: somewhere in the picture is a bar, somewhere an edge.
    box = bench.locator(".bench-canvas > canvas").bounding_box()
    seen = set()
    for step in range(40):
        bench.mouse.move(box["x"] + box["width"] * (0.3 + 0.01 * step), box["y"] + box["height"] * (0.3 + 0.01 * step))
        for what in (".bar-loop canvas", ".bench-canvas .lane-tip"):
            if bench.locator(what).count():
                seen.add(what)
    assert len(seen) == 2
    bench.get_by_role("button", name="List").click()
    with bench.expect_response(lambda answer: "/compose" in answer.url) as answer:
        bench.get_by_role("button", name=re.compile("Play: Transition from bar 1 to bar")).first.click()
    assert answer.value.status == 200
    assert len(answer.value.request.post_data_json["segments"]) == 2
    expect(bench.get_by_role("status").filter(has_text="From bar 1 to bar")).to_be_visible()
    expect(bench.get_by_role("slider", name="frame")).to_be_visible()


@pytest.mark.fuzz
def test_a_dry_run_keeps_to_what_is_allowed(open_studio: Served, visit_of: Any, bench: Any) -> None:
    for label, value in (("Bars", "4"),):
        bench.get_by_label(label, exact=True).fill(value)
        bench.get_by_label(label, exact=True).press("Enter")
    bench.get_by_role("button", name="Position 3: free").click()
    bench.get_by_label("Bars at position 3").fill("5 12")
    bench.get_by_label("Bars at position 3").press("Enter")
    bench.wait_for_url("**allow=3*")
    bench.get_by_role("button", name="Preview").click()
    expect(bench.get_by_text("Preview only: nothing was saved.")).to_be_visible()
    third = bench.get_by_role("button", name=re.compile("Position 3: Bar")).get_attribute("aria-label")
    assert int(third.split()[-1]) in (5, 12)
    expect(bench.get_by_role("rowheader", name="Foot skate in transitions")).to_be_visible()
    assert len(open_studio.get("/documents")["items"]) == 3


@pytest.mark.slow
def test_a_tempo_is_tapped_and_one_that_does_not_work_says_what_does(
    open_studio: Served, visit_of: Any, dances: list[str]
) -> None:
    visit = visit_of(open_studio)
    visit.wanted = {400, 422}
    page = visit.open(f"/dance?doc={dances[0]}")
    expect(page.locator(".bench-row")).to_have_count(1, timeout=60_000)
    page.evaluate(
        """() => { const clock = performance.now; let time = 1000;
        performance.now = () => time; const key = () => document.body.dispatchEvent(new KeyboardEvent("keydown",
        { code: "KeyT", key: "t", bubbles: true })); for (let at = 0; at < 5; at++) { key(); time += 480; }
        performance.now = clock; }"""
    )
    expect(page.get_by_label("Tempo", exact=True)).to_have_value("125")
    page.wait_for_url("**bpm=125*")
    page.get_by_label("Tempo", exact=True).fill("30")
    page.get_by_label("Tempo", exact=True).press("Enter")
    page.get_by_role("button", name="Create dance", exact=True).click()
    expect(page.get_by_role("alert").filter(has_text="Give a number from 40 to 240")).to_be_visible()


def drift(page: Any, seconds: float) -> None:
    """Play a dance: picture and sound stay within a frame of each other."""
    page.locator(".bench-moving .play").click()
    found = np.array(page.evaluate(SAMPLED, seconds))
    heard, exact, drawn, led = found.T
    sounding = (heard > 0.5) & (np.abs(exact - drawn) < 100)  # not where it begins again
    apart, behind = exact[sounding] - drawn[sounding] - 0.5, exact[sounding] - led[sounding]
    assert heard.max() > min(seconds, 15) * 0.8
    assert np.quantile(np.abs(apart), 0.98) < 1.0, "frames between what is heard and what is drawn"
    fifth = len(apart) // 5
    assert abs(np.median(behind[-fifth:]) - np.median(behind[:fifth])) < 0.5
    print(f"{seconds} s: {np.quantile(np.abs(apart), 0.98):.2f} frames apart, smoothing {np.abs(behind).max():.3f}")


@pytest.mark.slow
def test_a_dance_plays_in_step_with_its_clicks(bench: Any) -> None:
    """Ten seconds; three minutes in `make fuzz`."""
    make(bench, Bars="6", Tempo="120")
    drift(bench, 10)


@pytest.mark.fuzz(seeds=1)
def test_three_minutes_stay_in_step(bench: Any, seed: int) -> None:
    make(bench, Bars="92", Tempo="120", Seed=str(seed % 1000))
    drift(bench, 180)


@pytest.mark.fuzz
def test_a_dance_is_renamed_exported_and_taken_back(open_studio: Served, bench: Any) -> None:
    result = make(bench, Bars="4")
    document = open_studio.get(f"/results/{result}")["parts"]["clip"]["document"]
    bench.get_by_role("button", name="Save…").click()
    dialog = bench.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("first dance")
    dialog.get_by_label("Project").fill("stage")
    dialog.get_by_role("button", name="Save").click()
    expect(bench.get_by_role("dialog")).to_have_count(0)
    detail = open_studio.get(f"/documents/{document}")
    assert (detail["name"], detail["project"]) == ("first dance", "stage")
    bench.get_by_role("button", name="Export").click()
    with bench.expect_download() as download:
        bench.get_by_role("menuitem", name=re.compile("^BVH")).click()
    assert Path(download.value.path()).read_text().startswith("HIERARCHY")
    bench.get_by_role("button", name=re.compile("Play: Transition from bar")).first.click()
    bench.wait_for_function("() => window.mcmlDance.frame() > 0")
    bench.get_by_role("button", name="Undo", exact=True).last.click()
    expect(bench.get_by_text("dance deleted")).to_be_visible()
    assert document not in [one["id"] for one in open_studio.get("/documents")["items"]]


def song(bpm: float, seconds: float) -> bytes:
    """Clicks at a tempo, as WAV."""
    rate = 22_050
    samples = np.zeros(int(seconds * rate))
    length = int(0.04 * rate)
    tick = np.sin(2 * np.pi * 1000 * np.arange(length) / rate) * np.exp(-np.arange(length) / 150)
    for at in np.arange(0.5, seconds - 0.1, 60 / bpm):
        first = int(at * rate)
        samples[first : first + length] += tick
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(rate)
        out.writeframes((samples * 30_000).astype("<i2").tobytes())
    return file.getvalue()


@pytest.mark.slow
def test_music_is_danced_to_and_kept_with_the_dance(open_studio: Served, bench: Any) -> None:
    pytest.importorskip("librosa", reason="the extra audio is not installed")
    bench.get_by_label("Music", exact=True).set_input_files(
        {"name": "song.wav", "mimeType": "audio/wav", "buffer": song(120, 20)}
    )
    slider = bench.get_by_role("slider", name="Audio offset")
    expect(slider).to_be_visible(timeout=120_000)
    bench.keyboard.press("Shift+>")
    bench.keyboard.press("Shift+Period")
    bench.wait_for_url("**offset=0.02*")
    slider.press("ArrowRight")
    bench.get_by_label("First downbeat at beat").select_option("2")
    result = make(bench, Bars="4")
    wish = open_studio.get(f"/results/{result}")["parameters"]["music"]
    assert wish["downbeat"] == 2
    assert np.diff(wish["beats"]).mean() == pytest.approx(0.5, abs=0.01)
    document = open_studio.get(f"/results/{result}")["parts"]["clip"]["document"]
    media = open_studio.get(f"/documents/{document}")["media"]
    assert (media["name"], media["offset"]) == ("song.wav", 0.03)
    drift(bench, 4)
    # Who opens the dance later hears it too.
    bench.goto(f"{bench.url.split('/dance/')[0]}/dance/{result}")
    expect(bench.get_by_role("slider", name="Audio offset")).to_have_attribute("aria-valuetext", "0.03 s")
    assert bench.get_by_label("First downbeat at beat").input_value() == "2"


@pytest.mark.slow
def test_a_real_dance_is_danced_anew(open_studio: Served, visit_of: Any, shared: Path) -> None:
    path = shared / "bvh/dance/Gangnam-Style.bvh"
    if not path.is_file():
        pytest.skip("the real dances are not here")
    document = open_studio.upload("gangnam.bvh", path.read_bytes())
    page = visit_of(open_studio).open(f"/dance?doc={document}&near=0.4")
    lane = page.get_by_role("listbox", name="Beats of gangnam")
    expect(lane.get_by_role("option").first).to_contain_text("tracked")
    row = page.get_by_role("article", name="gangnam")
    expect(row.get_by_role("group").get_by_role("button").first).to_contain_text("130")
    lane.focus()
    lane.press("ArrowRight")
    page.get_by_text(re.compile("Rejected: ")).click()
    expect(page.get_by_role("cell", name=re.compile("F1|F2|F3")).first).to_be_visible()
    make(page, Bars="8", Tempo="128")
    drift(page, 3)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["dark", pytest.param("light", marks=pytest.mark.fuzz)])
def test_no_serious_fault_of_accessibility(bench: Any, scheme: str) -> None:
    bench.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    bench.get_by_role("button", name="Build motion graph").click()
    bench.wait_for_selector(".bench-canvas[data-laid]")
    bench.get_by_role("button", name="Position 2: free").click()
    bench.get_by_label("Beats: groove 1").select_option("tracked")
    make(bench, Bars="4")
    PICTURES.mkdir(parents=True, exist_ok=True)
    for width, height in ((1920, 1080), (1280, 800), (420, 800)):
        bench.set_viewport_size({"width": width, "height": height})
        assert bench.evaluate("() => document.documentElement.scrollWidth") <= width
        bench.screenshot(path=PICTURES / f"dance-{width}-{scheme}.png")
    for width in (1280, 420):
        bench.set_viewport_size({"width": width, "height": 800})
        assert serious_faults(bench) == []
