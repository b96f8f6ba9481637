"""Every page, in both themes and languages: no serious fault of accessibility, and a picture for a person to see."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mcml_schemas.analyses.dance import BeatsParameters
from mcml_service.actions.analysing.save_results import add_parts
from mcml_service.analysis.dance.analyses import BEATS
from mcml_service.analysis.interface import silent
from mcml_service.storage.database import Database
from service.web.build import WEB
from tests import fuzz
from tests.analysis.dance.motions import generated
from tests.analysis.expression.face_motions import motions
from tests.web.conftest import Served, serve, walk
from tests.web.test_faces import keep_space
from tests.web.test_journeys import ready
from tests.web.test_reach import keep_model

expect: Any = pytest.importorskip("playwright.sync_api").expect
AXE = WEB / "node_modules/axe-core/axe.min.js"
PICTURES = Path(".pytest_cache/pages")
"""Where pictures of pages are kept; CI shows them as an artefact."""

SIZES = {"wide": (1920, 1080), "narrow": (420, 800)}
"""The others are 1280 by 800."""


@pytest.fixture(scope="module")
def filled(sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Served, dict[str, str]]]:
    """A server with a few clips, and the addresses of all pages."""
    for served in serve(sqlite_template, tmp_path_factory.mktemp("pages"), closed=False):
        one = served.upload(
            "stride.bvh", walk(90), label="left-leg-flexion:10-40", property="age=23 year", project="Gait"
        )
        two = served.upload("kick.bvh", walk(40, seed=3), label="kick", project="Gait")
        for number in range(6):
            served.upload(f"take {number}.bvh", walk(20 + 5 * number, seed=number + 5))
        clip = f"/clips/{one}?f=20&sel=left_up_leg"
        result = beats_of(served.database)
        model = keep_model(served)
        space = keep_space(served.database, motions(noise=0.1))
        yield (
            served,
            {
                "library": "/library",
                "list": "/library?view=list",
                "nothing": "/library?q=nothing+is+called+so",
                "tree": clip,
                "graph": f"{clip}&tab=graph",
                "body": f"{clip}&tab=body",
                "structure": f"{clip}&tab=structure",
                "text": f"{clip}&tab=text",
                "history": f"{clip}&tab=history",
                "info": f"{clip}&tab=info",
                "xpath": "/xpath?q=//frame[motion_name='left-leg-flexion']",
                "xpath-empty": "/xpath",
                "composer": f"/compose?s={one}:10-60,{two}",
                "composer-empty": "/compose",
                "retarget": f"/retarget?from={one}&to={two}",
                "retarget-empty": "/retarget",
                "measure": "/measure?project=Gait&m=speed:left_up_leg|angle:left-knee-flexion",
                "measure-empty": "/measure",
                "analyses": "/analyses",
                "jobs": "/jobs",
                "analysis": "/analyses/beats?project=Gait",
                "result": f"/results/{result}",
                "result-table": f"/results/{result}?part=bars",
                "faces": f"/faces/{space}?level=1&keys=3",
                "faces-start": "/faces",
                "reach-empty": "/reach?project=demo-reach",
                "reach": f"/reach/{model}?near=side",
                "reach-gap": f"/reach/{model}?near=alone&age=45",
                "reach-examples": f"/reach/{model}?tab=examples",
                "reach-fit": f"/reach/{model}?tab=fit",
                "dance-start": "/dance",
                "settings": "/settings",
                "settings-project": "/settings/projects?project=Gait",
                "activity": "/settings/activity",
                "webhooks": "/settings/webhooks",
                "unknown": "/library/../nowhere",
            },
        )


def beats_of(database: Database) -> str:
    """A result, as a job would have kept it."""
    parts = BEATS.run([generated("groove", "a", bars=6)[0]], BeatsParameters(), silent)
    with database.write("kim") as tx:
        key, uuid = tx.results.add(tx.projects.get_or_add("Gait"), "beats", "beats of Gait", "kim", [], {}, {})
        add_parts(tx, key, parts, {})
    return uuid


PAGES = [
    "library", "list", "nothing", "tree", "graph", "body", "structure", "text", "history", "info", "xpath",
    "xpath-empty",
    "composer", "composer-empty", "retarget", "retarget-empty", "measure", "measure-empty", "analyses", "analysis",
    "jobs", "result", "result-table", "reach-empty", "reach", "reach-gap", "reach-examples", "reach-fit",
    "faces", "faces-start", "dance-start", "settings",
]  # fmt: skip


def shown(page: Any, name: str) -> None:
    """Until a page stands as a visitor sees it."""
    # Nothing has been waited for in so many frames one after the other.
    page.wait_for_function(
        """() => {
          const there = document.querySelector('main')?.childElementCount && !document.querySelector('.busy');
          window.still = there ? (window.still ?? 0) + 1 : 0;
          return window.still > 4;
        }"""
    )
    if name in ("tree", "graph", "body", "structure", "text", "history", "info"):
        ready(page)
    if name in ("library", "list"):
        page.wait_for_function("() => document.querySelectorAll('[data-id], .list-row[data-row]').length >= 8")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def turn_to(page: Any, path: str, name: str) -> None:
    """To another page as a link leads there: nothing is loaded anew but what the page needs."""
    page.evaluate(
        """path => {
          window.still = 0;
          history.pushState(null, '', path);
          dispatchEvent(new PopStateEvent('popstate'));
          return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
        }""",
        path,
    )
    shown(page, name)


def picture(page: Any, name: str, *about: str) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{'-'.join((name, *about))}.png")


def faults(page: Any) -> list[tuple[str, str, list[str]]]:
    """What axe-core finds on the page as it stands: rule, impact, elements."""
    page.evaluate(f"window.axe === undefined && (() => {{ {AXE.read_text(encoding='utf-8')} }})()")
    found = page.evaluate("() => axe.run({ resultTypes: ['violations'] })")["violations"]
    return [(one["id"], one["impact"], [node["html"][:160] for node in one["nodes"]][:4]) for one in found]


OVERLAPS = """() => {
  const boxes = [...document.querySelectorAll("main :is(input, select, textarea).field")]
    .map((field) => [field, field.getBoundingClientRect()]);
  return boxes.flatMap(([one, a], at) => boxes.slice(at + 1)
    .filter(([other, b]) =>
      one.parentElement.parentElement === other.parentElement.parentElement &&
      Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
      Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1)
    .map(([other]) => one.outerHTML.slice(0, 80) + " over " + other.outerHTML.slice(0, 80)));
}"""
"""Fields of neighbouring rows that lie over one another; others may be scrolled below a bar."""


def serious_faults(page: Any) -> list[tuple[str, list[str]]]:
    return [(rule, nodes) for rule, impact, nodes in faults(page) if impact in ("serious", "critical")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scheme", "locale", "size"), [("dark", "en", "wide"), ("light", "ko", "narrow"), ("light", "ja", "narrow")]
)
def test_pages(filled: Any, visit_of: Any, request: pytest.FixtureRequest, scheme: str, locale: str, size: str) -> None:
    """Every page, half of them in a narrow window (in `make fuzz` all, and in a wide one too): nothing goes wrong, no
    serious fault of accessibility, nothing is wider than the window, no field lies over another. Each is kept as a
    picture."""
    served, pages = filled
    page = visit_of(served, color_scheme=scheme, locale=locale, reduced_motion="reduce").open("/settings")
    sizes = {"normal": (1280, 800)}
    if size == "narrow" or fuzz.asked_for(request.config):
        sizes[size] = SIZES[size]
    found, wider, overlaps = {}, [], []
    # Half of them in each language, or it would take as long again.
    for name in PAGES if fuzz.asked_for(request.config) else PAGES[locale == "ko" :: 2]:
        turn_to(page, pages[name], name)
        for each, (width, height) in sizes.items():
            page.set_viewport_size({"width": width, "height": height})
            shown(page, name)
            picture(page, name, each, scheme, locale)
            if page.evaluate("() => document.documentElement.scrollWidth") > width:
                wider.append((name, each))
            overlaps += [(name, each, pair) for pair in page.evaluate(OVERLAPS)]
            if each == "normal" and (serious := serious_faults(page)):
                found[name] = serious
    assert found == {}, found
    assert wider == []
    assert overlaps == []


def nothing_found(page: Any) -> None:
    page.keyboard.press("Control+k")
    palette = page.get_by_role("dialog", name="Search everything")
    palette.get_by_role("combobox").fill("zzzz")
    expect(palette.get_by_role("status")).to_have_text("No results.")
    expect(palette.get_by_role("option")).to_have_count(0)


def files_above(page: Any) -> None:
    page.evaluate(
        """() => {
          const data = new DataTransfer();
          data.items.add(new File(["x"], "kick.bvh"));
          document.body.dispatchEvent(new DragEvent("dragenter", { dataTransfer: data, bubbles: true }));
        }"""
    )
    expect(page.get_by_role("region", name="Drop to import")).to_be_visible()


def refused(page: Any) -> None:
    expect(page.get_by_role("alert")).to_be_visible()


NOBODY = "00000000-0000-0000-0000-000000000000"
STATES = {
    "palette": ("/library", nothing_found),
    "drop": ("/library", files_above),
    "clip": (f"/clips/{NOBODY}", refused),
    "model": (f"/reach/{NOBODY}", refused),
    "projects": ("/settings/projects", lambda page: expect(page.get_by_role("heading", level=3)).not_to_have_count(0)),
    "webhooks": ("/settings/webhooks", lambda page: expect(page.get_by_role("heading", level=3)).not_to_have_count(0)),
}


@pytest.mark.parametrize("state", STATES)
def test_states(open_studio: Served, visit_of: Any, state: str) -> None:
    """What a page shows only after a deed or a refusal has no fault of accessibility, of any impact."""
    visit = visit_of(open_studio, reduced_motion="reduce")
    visit.wanted = {404}
    path, reach = STATES[state]
    page = visit.open(path)
    expect(page.locator("main > *")).not_to_have_count(0)
    reach(page)
    assert faults(page) == []
