"""Frame times as people write them, wherever they are asked for; and refusals in words of the library's own."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import mcml
from mcml.errors import DocumentError, RequestError
from mcml.files.check_names import check_frame_time
from mcml_service.cli import app
from tests.api.asked import API
from tests.builders import ASF, MCML, amc, bvh, one_kind, upload

EXACT = "0.008333333333333333"
SAID: list[tuple[Any, str]] = [
    ("0.0083333", "0.0083333"), (" 0.0083333 ", "0.0083333"), ("1/120", EXACT), ("1 / 120", EXACT), (1 / 120, EXACT),
    (Fraction(1, 120), EXACT), ("1001/30000", "0.03336666666666667"), ("1/59.94", "0.01668335001668335"), (1, "1.0"),
    (0.04, "0.04"), (1e-7, "0.0000001"), (np.float64(0.25), "0.25"), ("2.50", "2.50"),
]  # fmt: skip
WRONG: list[Any] = ["1/0", "1//120", "120 fps", "-1/120", "", "0", 0, -0.5, 1e7, float("nan"), float("inf"), "1e400"]


@pytest.mark.parametrize(("said", "text"), SAID)
def test_as_decimal_text(said: Any, text: str) -> None:
    assert check_frame_time(said) == text


@given(st.floats(1e-9, 1e6, exclude_max=True))
def test_a_float_is_the_same_number(number: float) -> None:
    text = check_frame_time(number)
    assert float(text) == number
    assert "e" not in text


@pytest.mark.parametrize("said", WRONG)
def test_what_is_no_time_is_refused(said: Any) -> None:
    with pytest.raises(DocumentError, match="is no time"):
        check_frame_time(said)


@one_kind
def test_the_api_takes_numbers_and_fractions(client: TestClient) -> None:
    made: Any = upload(client, {"leg.asf": ASF, "leg.amc": amc(4)})
    here = f"{API}/documents/{made['documents'][0]['id']}"
    for said, text in (("1/120", EXACT), (1 / 120, EXACT), (0.04, "0.04"), (1, "1.0"), ("0.0083333", "0.0083333")):
        answer = client.patch(here, json={"frame_time": said}, headers={"if-match": "*"})
        assert answer.status_code == 200, answer.text
        assert client.get(f"{here}/skeleton").json()["frame_time"] == text
    for said in ("1/0", True, [1], "soon", 0):
        assert client.patch(here, json={"frame_time": said}, headers={"if-match": "*"}).status_code == 422, said
    again: Any = upload(client, {"leg.asf": ASF, "leg.amc": amc(5)}, frame_time="1/60")
    other = again["documents"][0]
    assert other["receipt"]["frame_rate"]["frames_per_second"] == pytest.approx(60)
    third: Any = upload(client, {"leg.asf": ASF, "leg.amc": amc(6)})
    uuid = third["documents"][0]["id"]
    for said in ("1/25", "0.04"):
        file = client.get(f"{API}/documents/{uuid}/export", params={"format": "bvh", "frame_time": said})
        assert file.status_code == 200, file.text
        assert b"Frame Time: 0.04" in file.content
    packed = {"selection": {"documents": [uuid]}, "format": "bvh", "frame_time": 1 / 25}
    assert client.post(f"{API}/exports", json=packed).status_code == 200
    text = {"xpath": "/mcml/motion/frametime"}
    set_ = client.patch(f"{here}/elements", params=text, json={"text": "1/50"}, headers={"if-match": "*"})
    assert set_.status_code == 200, set_.text
    assert client.get(f"{here}/skeleton").json()["frame_time"] == "0.02"


TIMES: list[Any] = [1 / 120, "1/120", Fraction(1, 120), np.float64(1 / 120), EXACT]


def leg(folder: Path) -> list[Path]:
    (folder / "leg.asf").write_bytes(ASF)
    (folder / "leg.amc").write_bytes(amc(4))
    return [folder / "leg.asf", folder / "leg.amc"]


@pytest.mark.parametrize("said", TIMES)
def test_the_python_package_takes_them(tmp_path: Path, said: Any) -> None:
    files = leg(tmp_path)
    assert mcml.read(files, frame_time=said).frame_time == 1 / 120
    mcml.convert(files, tmp_path / "leg.bvh", frame_time=said)
    assert f"Frame Time: {EXACT}".encode() in (tmp_path / "leg.bvh").read_bytes()
    with mcml.open(str(tmp_path / "store.db")) as repo:
        (first,) = repo.import_(*files, on_duplicate="new").documents
        assert first.set(frame_time=said).frame_time == 1 / 120
        (second,) = repo.import_(*files, frame_time=said, on_duplicate="new").documents
        assert second.frame_time == 1 / 120
        (third,) = repo.import_(*files, on_duplicate="new").documents
        third.export(tmp_path / "third.bvh", frame_time=said)
        assert first.set(frame_time=Decimal("0.04")).frame_time == 0.04


def test_the_command_line_takes_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    leg(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MCML_DATABASE", f"sqlite:///{tmp_path}/store.db")

    def run(*words: str) -> str:
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, (done.output, done.exception)
        return done.output

    run("import", "leg.asf", "leg.amc", "--frame-time", "1/120")
    run("set", "--project", "default", "--frame-time", "1/60")
    run("convert", "leg.asf", "leg.amc", "out.bvh", "--frame-time", "1/120")
    assert f"Frame Time: {EXACT}".encode() in (tmp_path / "out.bvh").read_bytes()


def test_no_error_of_pydantic_leaves_the_package(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_bytes(bvh(4))
    (tmp_path / "hand.mcml").write_bytes(MCML)
    with mcml.open(str(tmp_path / "store.db")) as repo:
        document = repo.import_(tmp_path / "a.bvh").documents[0]
        for field, wrong in (
            ("frame_time", lambda: document.set(frame_time=True)),
            ("frame_time", lambda: document.set(frame_time=[1])),
            ("unit", lambda: document.set(unit=3)),
            ("nothing", lambda: document.set(nothing="x")),
            ("name", lambda: document.rename("")),
            ("name", lambda: document.rename(3)),  # type: ignore[arg-type]
            ("project", lambda: document.move("")),
            ("first", lambda: document.label("walk", first="x")),  # type: ignore[arg-type]
            ("first", lambda: document.label("walk", first=0)),
            ("space", lambda: document.frames(space="x")),  # type: ignore[arg-type]
            ("last", lambda: document.frames(last=0)),
            ("q", lambda: repo.xpath("").value()),
            ("guesses", lambda: repo.xpath("//frame", guesses="x").value()),
        ):
            with pytest.raises(RequestError, match=field):
                print(field, wrong())
