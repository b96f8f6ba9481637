"""Analyses in the browser: a form made of a schema, progress, and a result shown by the kinds of its parts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from playwright.sync_api import expect
from pydantic import BaseModel, Field

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis import catalogue
from mcml_service.analysis.interface import Analysis, Answer, PartInfo, ResultUse
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.settings import Settings
from tests.web.conftest import Served, serve, walk

pytestmark = pytest.mark.usefixtures("lent_workers")


class Strides(BaseModel):
    """Parameters of an analysis that no page knows."""

    foot: Literal["left", "right"] = Field("left", description="The foot that counts")
    least: Annotated[float, Field(ge=0, le=2)] = Field(0.25, title="Shortest stride", description="Metres")
    names: list[str] = Field(default_factory=list, description="Names to write")


class Steps(BaseModel):
    count: int = 3


TOY = Analysis(
    name="strides",
    title="Strides of walkers",
    description="How long each stride is.",
    parameters=Strides,
    parts={"lengths": PartInfo("curve", "Length of each stride")},
    run=lambda motions, parameters, progress: {},
    operations={"count": ResultUse("Count the strides", Steps, Steps, lambda parts, wish: Answer(wish))},
)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(catalogue.ANALYSES, "strides", TOY)  # type: ignore[arg-type]  # a dict, whatever its type says
    monkeypatch.setitem(catalogue.SUBJECTS, "steps", {"strides": TOY})  # type: ignore[arg-type]


@pytest.mark.slow
def test_an_analysis_that_is_added_has_a_form_and_results(
    toy: None, visit_of: Any, sqlite_template: Path, tmp_path: Path
) -> None:
    for served in serve(sqlite_template, tmp_path, closed=False):
        served.upload("stride.bvh", walk(30), project="Gait")
        with served.database.write("kim") as tx:
            key, _uuid = tx.results.add(tx.projects.get_or_add("Gait"), "strides", "old strides", "kim", [], {}, {})
            lengths = np.linspace(0.5, 0.7, 20)
            data = {"x": {"name": "stride"}, "y": {"name": "lengths", "unit": "m"}}
            tx.results.add_part(key, "lengths", "curve", data, {"lengths": lengths})
            table = {"columns": [{"name": "foot"}, {"name": "mean", "unit": "m"}], "rows": [["left", 0.6125]]}
            tx.results.add_part(key, "means", "table", table, {})
        page = visit_of(served).open("/analyses")
        page.get_by_role("link", name="Strides of walkers").click()
        assert page.get_by_label("foot").input_value() == "left"
        least = page.get_by_label("Shortest stride")
        least.fill("7")
        expect(page.get_by_text("Enter a number from 0 to 2.")).to_be_visible()
        least.fill("0.5")
        expect(page.get_by_text("Metres")).to_be_visible()
        assert page.get_by_role("button", name="Run Strides").is_disabled(), "no clip is chosen yet"
        page.get_by_label("Project").select_option("Gait")
        expect(page.get_by_role("link", name="stride", exact=True)).to_be_visible()
        expect(page.get_by_role("button", name="Run Strides")).to_be_enabled()
        page.get_by_role("link", name="old strides").click()
        page.get_by_role("button", name="lengths").click()
        expect(page.get_by_role("img", name="lengths")).to_be_visible()
        page.get_by_role("button", name="means").click()
        expect(page.get_by_role("cell", name="0.6125")).to_be_visible()
        expect(page.get_by_text("Count the strides")).to_be_visible()


@pytest.mark.slow
def test_an_analysis_runs_and_its_result_is_seen(open_studio: Served, visit_of: Any) -> None:
    clips = [dance_clip("groove", bars=6, seed=seed, name=f"groove {seed}").clip for seed in (1, 2, 3)]
    add_clips(open_studio.database, Settings(), "dances", clips, (), "")
    page = visit_of(open_studio).open("/analyses/beats?project=dances")
    page.get_by_role("checkbox", name="groove 3").uncheck()
    page.get_by_label("Result name").fill("two grooves")
    page.get_by_role("button", name="Run Beats and bars").click()
    page.wait_for_url("**/results/*")
    picture = page.get_by_role("img", name="Speed of each clip")
    expect(picture).to_be_visible()
    page.wait_for_function("() => document.querySelector('.result-picture img').naturalWidth > 100")
    result = open_studio.get("/results")["items"][0]
    assert (result["name"], len(result["inputs"])) == ("two grooves", 2)
    page.get_by_role("button", name="speed", exact=True).click()
    expect(page.get_by_role("img", name="speed")).to_be_visible()
    page.get_by_role("button", name="bars", exact=True).click()
    bars = open_studio.get(f"/results/{result['id']}")["parts"]["bars"]["data"]["rows"]
    assert page.locator(".part-table tbody tr").count() == len(bars) > 4
    page.get_by_role("button", name="Jobs").click()
    expect(page.get_by_role("link", name="Open result")).to_be_visible()


@pytest.mark.slow
def test_the_log_of_jobs_says_how_each_ended_and_runs_them_again(open_studio: Served, visit_of: Any) -> None:
    clips = [dance_clip("groove", bars=6, seed=seed, name=f"groove {seed}").clip for seed in (1, 2)]
    add_clips(open_studio.database, Settings(), "dances", clips, (), "")
    page = visit_of(open_studio).open("/jobs")
    expect(page.get_by_text("No jobs yet.")).to_be_visible()
    with open_studio.client() as client:
        for analysis in ("beats", "reach"):
            body = {"inputs": {"project": "dances"}, "name": f"{analysis} by another window"}
            assert client.post(f"/analyses/{analysis}", json=body).status_code == 202
    page.reload()
    done = page.locator("tbody tr[data-state=done]")
    failed = page.locator("tbody tr[data-state=failed]")
    expect(done).to_have_count(1, timeout=60_000)
    expect(failed.locator(".reason")).to_contain_text("The clip has no property 'age'", timeout=60_000)
    page.get_by_label("State").select_option("failed")
    expect(page.locator("tbody tr")).to_have_count(1)
    page.get_by_label("State").select_option("")
    done.get_by_role("button", name="Run again").click()
    expect(done).to_have_count(2, timeout=60_000)
    assert [job["name"] for job in open_studio.get("/jobs")["items"]].count("beats by another window") == 2
    done.first.get_by_role("link").click()
    page.wait_for_url("**/results/*")
