"""What is done with whole projects in the studio: limits, archive, file; clips on their way to another one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
@one_door
def test_a_project_is_bounded_archived_and_comes_back_as_another(visit: Visit, studio: Served, tmp_path: Path) -> None:
    studio.upload("walk.bvh", walk(), project="gait")
    page = visit.open("/settings/projects?project=gait")
    page.get_by_role("button", name="Edit quotas").click()
    page.get_by_label("Clips (max.)").fill("4")
    page.get_by_label("File size (max.)").fill("1.5")
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_text("1 of 4")).to_be_visible()
    expect(page.get_by_text("of 1.5 GB")).to_be_visible()
    with page.expect_download() as saved:
        page.get_by_role("link", name="Export to file").click()
    assert saved.value.suggested_filename == "gait.project.zip"
    saved.value.save_as(file := tmp_path / "gait.project.zip")

    page.get_by_role("button", name="Archive").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Until it is reopened")
    dialog.get_by_role("button", name="Archive").click()
    expect(page.get_by_text("Archived since")).to_be_visible()
    assert studio.get("/project", project="gait")["archived"]
    page.get_by_role("button", name="Reopen").click()
    page.get_by_role("dialog").get_by_role("button", name="Reopen").click()
    expect(page.get_by_text("Archived since")).to_have_count(0)

    visit.wanted.add(409)
    page.get_by_label("Choose file").set_input_files(file)
    page.get_by_role("button", name="Import", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("There is a project 'gait'.")
    page.get_by_label("Project name").fill("gait 2")
    page.get_by_role("button", name="Import", exact=True).click()
    expect(page.get_by_text("Project gait 2 created with 1 clip")).to_be_visible()
    expect(page.get_by_label("Project", exact=True)).to_have_value("gait 2")


@pytest.mark.slow
@one_door
def test_a_project_s_file_is_dropped_and_a_broken_one_is_told(visit: Visit, studio: Served) -> None:
    page = visit.open("/settings/projects")
    page.get_by_role("button", name="Choose file").wait_for()
    files = page.evaluate_handle(
        "() => { const data = new DataTransfer(); data.items.add(new File(['none'], 'x.project.zip')); return data; }"
    )
    page.dispatch_event("body", "dragenter", {"dataTransfer": files})
    expect(page.get_by_role("heading", name="Drop a project file")).to_be_visible()
    page.dispatch_event("body", "drop", {"dataTransfer": files})
    visit.wanted.add(422)
    page.get_by_role("button", name="Import", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("zip")
    page.get_by_role("button", name="New project").click()
    page.get_by_role("dialog").get_by_label("Name").fill("later")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Project later created")).to_be_visible()
    # It has a page of its own before its first clip, and is a target of imports.
    expect(page.get_by_label("Project", exact=True)).to_have_value("later")
    expect(page.get_by_role("button", name="Archive")).to_be_visible()
    assert studio.get("/projects")["items"] == ["later"]
    page.goto(f"{studio.url}/library?project=later")
    expect(page.get_by_role("heading", name="No clips in later yet")).to_be_visible()


@pytest.mark.parametrize("studio", ["session"], indirect=True)
def test_who_does_not_own_a_project_is_told_why(studio: Served, visit_of: Any) -> None:
    studio.upload("walk.bvh", walk(), project="gait")
    with studio.database.write("test") as tx:
        studio.token = tx.tokens.add("reader", scope="read")
    page = visit_of(studio).open("/settings/projects?project=gait")
    expect(page.get_by_role("button", name="Export to file")).to_be_disabled()
    expect(page.get_by_text("Only owners of the project can export it.")).to_be_visible()
    for control in ("Archive", "Edit quotas", "New project", "Choose file"):
        expect(page.get_by_role("button", name=control)).to_have_count(0)
    page.goto(f"{studio.url}/library?project=gait")
    page.get_by_role("button", name="Select walk").click()
    bar = page.get_by_role("toolbar", name="1 selected")
    expect(bar.get_by_role("button", name="Delete")).to_have_count(0)
    expect(bar.get_by_role("button", name="Project")).to_have_count(0)
    expect(bar.get_by_role("button", name="Export")).to_be_visible()


@one_door
def test_picked_clips_are_copied_and_moved_to_a_project(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.bvh", walk(), project="gait")
    page = visit.open("/library?project=gait")
    page.get_by_role("button", name="Select walk").click()
    bar = page.get_by_role("toolbar", name="1 selected")

    def send(how: str, project: str) -> None:
        bar.get_by_role("button", name="Project").click()
        page.get_by_role("menuitem", name=f"{how} to a project").click()
        page.get_by_role("dialog").get_by_label("Project", exact=True).fill(project)
        page.get_by_role("button", name=how, exact=True).click()

    send("Copy", "dance")
    expect(page.get_by_text("1 clip copied to dance")).to_be_visible()
    assert studio.get("/documents", project="dance")["total"] == 1
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("1 clip deleted")).to_be_visible()
    send("Move", "dance")
    expect(page.get_by_text("1 clip moved to dance")).to_be_visible()
    expect(bar).to_have_count(0)
    assert studio.get(f"/documents/{uuid}")["project"] == "dance"
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("1 clip moved back")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["project"] == "gait"
