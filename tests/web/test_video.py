"""The video beside a motion: aligned by two clicks, and measured by drawing on its picture."""

from __future__ import annotations

from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect

RECORD = """async (address) => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [320, 240];
    const pen = canvas.getContext("2d");
    const recorder = new MediaRecorder(canvas.captureStream(25), { mimeType: "video/webm" });
    const parts = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    const ended = new Promise((resolve) => { recorder.onstop = resolve; });
    recorder.start();
    for (let picture = 0; picture < 50; picture++) {
        pen.fillStyle = `hsl(${7 * picture} 80% 40%)`;
        pen.fillRect(0, 0, 320, 240);
        await new Promise((resolve) => setTimeout(resolve, 40));
    }
    recorder.stop();
    await ended;
    const form = new FormData();
    form.append("file", new Blob(parts, { type: "video/webm" }), "take 3.webm");
    const answer = await fetch(address, { method: "PUT", body: form });
    return answer.status;
}"""
"""A film of two seconds in changing colours, made by the browser and attached to a document."""


def offset_of(studio: Served, uuid: str) -> Any:
    return studio.get(f"/documents/{uuid}")["media"]["offset"]


def film(visit: Visit, studio: Served) -> tuple[Any, str]:
    uuid = studio.upload("kick.bvh", walk(120))
    page = visit.open(f"/clips/{uuid}")
    assert page.evaluate(RECORD, f"/api/v1/documents/{uuid}/media") == 200
    page = visit.open(f"/clips/{uuid}?tab=video")
    page.wait_for_function("() => document.querySelector('.media-picture video')?.readyState >= 3")
    return page, uuid


@one_door
def test_a_moment_and_a_frame_align_the_video(visit: Visit, studio: Served) -> None:
    page, uuid = film(visit, studio)
    expect(page.locator("video")).to_have_count(1)
    page.get_by_role("button", name="Align with the motion").click()
    page.evaluate("() => { document.querySelector('video').currentTime = 0.7; }")
    page.wait_for_function("() => !document.querySelector('video').seeking")
    page.get_by_role("button", name="Use this moment").click()
    frame = page.locator(".frame-field")
    frame.fill("25")
    frame.press("Enter")
    page.get_by_role("button", name="Use frame 25").click()
    expect(page.get_by_text("The motion begins at")).to_be_visible()
    assert abs(offset_of(studio, uuid) - (0.7 - 24 * 0.0083333)) < 1e-3
    page.wait_for_function("() => Math.abs(document.querySelector('video').currentTime - 0.7) < 0.07")
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_label("Motion begins at")).to_have_value("0")
    assert offset_of(studio, uuid) == 0


@one_door
def test_angles_and_lengths_are_drawn_on_the_picture(visit: Visit, studio: Served) -> None:
    page, _ = film(visit, studio)
    page.get_by_role("button", name="Measure angle").click()
    drawn = page.locator(".drawing-list li")
    expect(drawn).to_contain_text("Angle 90°")
    end = page.locator(".drawings circle").first
    box, picture = end.bounding_box(), page.locator(".media-picture video").bounding_box()
    assert box
    assert picture
    # The first leg from level to 45 degrees below: as far down as it is to the right, 135 degrees from the other.
    part = min(picture["width"] / 320, picture["height"] / 240) * 240 / 5
    at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0], at[1] + part, steps=4)
    page.mouse.up()
    expect(drawn).to_contain_text("Angle 135")
    page.get_by_role("button", name="Measure length").click()
    length = drawn.last
    expect(length).to_contain_text("96 px")
    length.get_by_label("True length").fill("1.92")
    length.get_by_label("True length").press("Enter")
    expect(length).to_contain_text("1.92 m")
    point = page.locator(".drawings circle").last
    point.focus()
    point.press("Shift+ArrowRight")
    expect(length).to_contain_text("2.12 m")
    # Of another picture they are not shown, and lead back to their own.
    page.locator(".frame-field").fill("60")
    page.locator(".frame-field").press("Enter")
    expect(page.locator(".drawings circle")).to_have_count(0)
    length.get_by_role("button", name="Go to").click()
    expect(page.locator(".drawings circle")).to_have_count(5)
    length.get_by_role("button", name="Remove Length").click()
    expect(drawn).to_have_count(1)
