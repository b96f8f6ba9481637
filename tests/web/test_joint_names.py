"""Names of joints in the studio: recognised ones are told from guesses, and another is chosen by a click."""

from __future__ import annotations

from typing import Any

import pytest

from tests.builders import bvh
from tests.web.conftest import Served

expect: Any = pytest.importorskip("playwright.sync_api").expect

RIG = ("Becken", "Wirbel", "LeftUpLeg", "LeftLeg", "LeftFoot", "Haupt")


def test_a_joint_is_clicked_and_named(open_studio: Served, visit_of: Any) -> None:
    walk = open_studio.upload("walk.bvh", bvh(5, names=RIG))
    before = [bone["name"] for bone in open_studio.get(f"/documents/{walk}")["bones"]]
    wrong = RIG[3]
    assert before[3] == "left_low_leg"
    page = visit_of(open_studio).open(f"/clips/{walk}?tab=structure")
    named = sum(bool(bone["mapped"]) for bone in open_studio.get(f"/documents/{walk}/skeleton")["bones"])
    expect(page.get_by_text(f"{named} of 6 joints recognised")).to_be_visible()
    page.get_by_role("treeitem", name="left_low_leg").click()
    field = page.get_by_label("Joint name")
    expect(field).to_have_value("left_low_leg")
    page.get_by_label("Also for later imports in this project").check()
    field.select_option("left_foot")
    expect(page.get_by_role("heading", name="left_foot")).to_be_visible()
    expect(page.get_by_text("revision 2")).to_be_visible()
    after = [bone["name"] for bone in open_studio.get(f"/documents/{walk}")["bones"]]
    assert (after[3], after[4]) == ("left_foot", "LeftFoot")
    aliases = open_studio.get("/aliases")["items"]
    assert {"source": wrong, "name": "left_foot"} in aliases
    # The joint that lost the name is hollow, and gets one again.
    page.get_by_role("treeitem", name="LeftFoot").click()
    expect(page.get_by_label("Joint name")).to_have_value("")
