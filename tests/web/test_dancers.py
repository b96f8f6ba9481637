"""Several dancers in the browser: asked for, made, and their ways on the floor."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.web.conftest import Served
from tests.web.test_dance import bench, dances, make
from tests.web.test_pages import serious_faults

__all__ = ["bench", "dances"]
pytestmark = pytest.mark.usefixtures("lent_workers")


@pytest.mark.slow
def test_three_dancers_in_canon_are_made_and_seen(open_studio: Served, bench: Any) -> None:
    expect(bench.get_by_label("Spacing (m)")).to_have_count(0)
    for label, value in (("Bars", "8"), ("Dancers", "3")):
        bench.get_by_label(label, exact=True).fill(value)
        bench.get_by_label(label, exact=True).press("Enter")
    expect(bench.get_by_label("Delay (bars)")).to_have_count(0)
    bench.locator(".bench-bar").get_by_label("Mode").select_option("canon")
    result = open_studio.get(f"/results/{make(bench, **{'Delay (bars)': '2', 'Spacing (m)': '1.5'})}")
    wish = result["parameters"]["dancers"]
    assert (wish["count"], wish["mode"], wish["delay"], wish["spacing"]) == (3, "canon", 2, 1.5)
    floor = bench.get_by_role("img", name="Paths on the floor")
    expect(floor.locator("polyline")).to_have_count(3)
    expect(floor.locator("[data-dancer]")).to_have_count(3)
    spots = [float(one.get_attribute("cx")) for one in floor.locator("[data-dancer]").all()]
    assert np.diff(spots) == pytest.approx([1.5, 1.5], abs=1e-6)
    expect(bench.get_by_role("row", name=re.compile("Least distance of two dancers"))).to_be_visible()
    assert not serious_faults(bench)
