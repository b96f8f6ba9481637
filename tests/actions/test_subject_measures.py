"""Measures of the subjects of a C3D file become properties, beside those of the user, and can be asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient

import mcml
from mcml.formats.c3d.events import read_events
from mcml.formats.c3d.parameters import read_statements
from tests.builders import one_kind, upload
from tests.c3d_writer import Value
from tests.laboratory.gait_files import gait_file, walk

pytestmark = one_kind

STATED = {"Bodymass": 60.0, "Height": 1634.0, "LKneeWidth": 100.0, "LLegLength": 880.0}
BENT = 5.0
"""Degrees: nobody in these trials bends the knee by 15, as the documentation asks."""

STRIKES_OF_OLD = (
    "/mcml[header/property[@name = 'age']/@value > 60]"
    "//frame[motion_name = 'left-foot-strike'][mo:quantity('LKneeAngles', 'x') > 15]"
)
"""The example of docs/analyses/gait.md."""


def numbers(*values: float) -> Value:
    return 4, (), list(values)


def properties_of(client: TestClient, content: bytes, **form: object) -> dict[str, tuple[str, str]]:
    """(value, unit) of each property of a new document, by name."""
    (item,) = upload(client, {"trial.c3d": content}, **form)["documents"]  # type: ignore[misc]
    facts = client.get(f"/api/v1/documents/{item['id']}").json()
    return {each["name"]: (each["value"], each.get("unit") or "") for each in facts["properties"]}


def file_of(measures: Mapping[str, float], subjects: tuple[str, ...] = (), **more: Value) -> bytes:
    parameters = {name.replace("__", ":"): value for name, value in more.items()}
    return gait_file(walk(4), measures, subjects=subjects, more=parameters)


def test_measures_are_properties_with_units(client: TestClient) -> None:
    content = file_of(STATED | {"RKneeWidth": 0.0, "LThighRotation": 0.1, "MarkerDiameter": 14.0, "Fps": 7.0})
    assert properties_of(client, content) == {
        "gait Bodymass": ("60", "kg"),
        "gait Height": ("1634", "mm"),
        "gait LKneeWidth": ("100", "mm"),
        "gait LLegLength": ("880", "mm"),
        "gait LThighRotation": ("0.1", "rad"),
    }
    documents = client.get("/api/v1/documents", params={"property": "gait Bodymass:50..70"}).json()["items"]
    assert len(documents) == 1


def test_a_receipt_says_so(client: TestClient) -> None:
    (item,) = upload(client, {"trial.c3d": file_of(STATED)})["documents"]  # type: ignore[misc]
    notices = item["receipt"]["notices"]
    assert any("measures of the subject are properties of the document: gait Bodymass" in str(each) for each in notices)


def test_values_of_the_user_stay(client: TestClient) -> None:
    properties = properties_of(client, file_of(STATED), property=["gait lkneewidth=99 mm", "age=71 year"])
    assert properties["gait lkneewidth"] == ("99", "mm")
    assert "gait LKneeWidth" not in properties
    assert properties["gait LLegLength"] == ("880", "mm")


def test_each_of_several_subjects_has_its_own(client: TestClient) -> None:
    own = {"AnnaBodymass": 50.0, "Annabel_Bodymass": 60.0, "Bodymass": 99.0, "AnnabelLLegLength": 900.0}
    content = file_of(own, ("Anna", "Annabel"), ANNA__LLegLength=numbers(700.0))
    assert properties_of(client, content) == {
        "gait Anna Bodymass": ("50", "kg"),
        "gait Anna LLegLength": ("700", "mm"),
        "gait Annabel Bodymass": ("60", "kg"),
        "gait Annabel LLegLength": ("900", "mm"),
    }


def test_odd_names_of_subjects_are_names_of_properties(client: TestClient) -> None:
    content = file_of({"C_Bodymass": 60.0}, ("A:\nB", "C"), AB__Bodymass=numbers(50.0))
    assert set(properties_of(client, content)) == {"gait A__B Bodymass", "gait C Bodymass"}


def test_too_many_subjects_give_a_warning_instead(client: TestClient) -> None:
    names = tuple(f"s{number:02}" for number in range(21))
    assert properties_of(client, file_of({f"{name}_Bodymass": 50.0 for name in names}, names)) == {}


@pytest.mark.parametrize(
    ("group", "stated", "expected"),
    [
        ("SUBJECT", {"HEIGHT": 1.63}, {"gait Height": "1630"}),
        ("PROCESSING", {"LLegLength": 0.88, "LKneeWidth": 0.1}, {"gait LLegLength": "880", "gait LKneeWidth": "100"}),
        ("PROCESSING", {"LKneeWidth": 0.1, "Bodymass": 60.0}, {"gait Bodymass": "60"}),
        ("PROCESSING", {"Height": 71.0}, {"gait Height": "710"}),
        ("PROCESSING", {"Height": 0.0, "Bodymass": float("nan")}, {}),
        ("PROCESSING", {"LLegLength": 9e9, "Bodymass": -3.0}, {}),
    ],
)
def test_units_are_those_in_which_people_have_legs(
    client: TestClient, group: str, stated: Mapping[str, float], expected: Mapping[str, str]
) -> None:
    """Lengths whose unit nothing tells are no properties."""
    properties = properties_of(client, gait_file(walk(4), stated, group=group))
    assert {name: value for name, (value, _) in properties.items()} == expected


def test_strikes_of_people_over_sixty_with_a_bent_knee(client: TestClient, shared: Path) -> None:
    lab = shared / "lab"
    if not lab.is_dir():
        pytest.skip("the trials of laboratories are not in the folder of MCML_SHARED")
    ages = {"hc030a05": 61, "s4_am_gait04": 60, "mh0222_bp06": 72}
    ids: dict[str, str] = {}
    for name, age in ages.items():
        content = (lab / f"{name}.c3d").read_bytes()
        (item,) = upload(client, {f"{name}.c3d": content}, property=[f"age={age} year"])["documents"]  # type: ignore[misc]
        ids[item["id"]] = name
    assert client.post("/api/v1/xpath", json={"q": STRIKES_OF_OLD}).json()["items"] == []
    question = STRIKES_OF_OLD.replace("> 15", f"> {BENT}") + "/@id"
    answer = client.post("/api/v1/xpath", json={"q": question}).json()
    assert not answer["warnings"]
    listed = {(ids[item["document"]], int(item["value"])) for item in answer["items"]}
    expected = set()
    for name, age in ages.items():
        with (lab / f"{name}.c3d").open("rb") as stream:
            said = read_statements(stream, [])
            events = read_events(said, [])
        motion = mcml.read(lab / f"{name}.c3d")
        knee, first = motion.quantity("LKneeAngles", "x"), int(said.words[3])
        for event in events:
            if age > 60 and (event.context, event.label) == ("Left", "Foot Strike"):
                frame = round(event.frame(said.rate))
                if np.isfinite(knee[frame - first]) and knee[frame - first] > BENT:
                    expected.add((name, frame))
    assert listed == expected
    assert expected


def test_a_changed_measure_moves_the_knee(client: TestClient) -> None:
    """The body of a clip is made with the properties that it has now."""
    content = gait_file(walk(4), {"Bodymass": 60.0})
    (item,) = upload(client, {"trial.c3d": content})["documents"]  # type: ignore[misc]

    def breadth() -> float:
        """Metres from the marker of the knee to its centre."""
        answer = client.post("/api/v1/xpath", json={"q": "avg(//frame/mo:distance('LKNE', 'left_low_leg'))"}).json()
        return float(answer["value"])

    usual = breadth()
    assert 0.03 < usual < 0.09
    for width in (90, 130):
        table = f"document,gait LKneeWidth (mm)\n{item['id']},{width}\n"
        assert client.post("/api/v1/properties", content=table).status_code == 200
        assert breadth() == pytest.approx((width + 14) / 2000, abs=2e-4)
    assert client.post("/api/v1/properties", content=f"document,gait LKneeWidth\n{item['id']},nonsense\n").is_success
    assert breadth() == pytest.approx(usual)
