"""The rate of a document may be a frame time or frames a second in its header: every answer is the same for both.

Where both are there and differ, the frame time counts: people state it.
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as parquet
import pytest
from fastapi.testclient import TestClient

from mcml.files.motion import convert
from mcml_service.storage.database import Database
from tests.builders import one_kind, served, upload
from tests.motion.bodies.made import person

API = "/api/v1"
RATE = 24
HEADER_BEFORE = ("filetype", "datatype", "filename", "version", "skeleton_name", "num_segments", "num_frames")
READS = (
    "/skeleton",
    "/calibration",
    "/gait",
    "/frames?format=npz&step=3",
    "/frames?format=csv&step=2&first=3",
    "/frames?format=npz&space=positions&step=2",
    "/frames?format=npz&step=2&quantity=speed:left_hand",
    "/frames?format=parquet&step=4",
    "/frames?format=block&step=2",
    "/export?format=bvh",
    "/export?format=bvh&fps=12",
    "/export?format=htr",
    "/export?format=glb",
    "/export?format=usd",
    "/export?format=csv",
    "/export?format=smpl",
    "/export?format=c3d",
    "/export?for=unreal",
)
QUESTIONS: tuple[dict[str, Any], ...] = (
    {"q": "//frame/mo:speed('Head')"},
    {"q": "//frame[mo:time() > 0.4]/@id"},
    {"q": "//frame[mo:contact('left') = 1]", "as": "runs", "with": "totals,range"},
    {"q": "for $f in //frame return mo:acceleration($f, 'Head')"},
    {"q": "//bone[1]/name | //frame[2]"},
    {"q": "//frame[mo:speed('left_hand') > 0.1]", "as": "runs"},
)


@pytest.fixture
def client(database: Database) -> TestClient:
    return served(database)


def pair(client: TestClient, form: str, folder: Path, *, both: bool) -> tuple[str, str]:
    """The same motion twice, in projects of their own: with a frame time, and with a rate in the header."""
    (folder / "a.bvh").write_bytes(person(5, 60, 1 / RATE))
    files = convert(folder / "a.bvh", folder / "b", to=form, unit="cm", up="Y") if form != "bvh" else [folder / "a.bvh"]
    sent = {f"{path.stem}.{path.suffix[1:] or form}": path.read_bytes() for path in files}
    first = upload(client, sent, frame_time=str(1 / RATE))["documents"][0]["id"]  # type: ignore[index]
    text = client.get(f"{API}/documents/{first}/export?format=mcml").text
    bare = re.sub(r"<source .*?(/>|</source>)\s*|<(frametime|dataframe_rate)>.*?</\2>\s*", "", text, flags=re.DOTALL)
    timed = re.sub(r"(</frames>)", rf"\1<frametime>{1 / RATE!r}</frametime>", bare)
    rated = with_rate(timed, 2 * RATE) if both else with_rate(bare, RATE)
    made = [
        upload(client, {"a.mcml": content.encode()}, project=project)["documents"][0]["id"]  # type: ignore[index]
        for content, project in ((timed, "timed"), (rated, "rated"))
    ]
    return made[0], made[1]


def with_rate(text: str, rate: float) -> str:
    """The document with the rate in its header, in the place that the definition gives it."""
    before = max(text.rfind(f"</{name}>") + len(name) + 3 for name in HEADER_BEFORE if f"</{name}>" in text)
    return f"{text[:before]}<dataframe_rate>{rate}</dataframe_rate>{text[before:]}"


def plain(text: str, uuid: str, project: str) -> str:
    """An answer without what tells the two documents from each other."""
    text = text.replace(uuid, "ID").replace(project, "PROJECT")
    text = re.sub(r'"(created|modified|skeleton|bytes|size|sha256|next_cursor)": ?[^,}]*', r'"\1":0', text)
    return re.sub(r'"(frame_time|dataframe_rate)": ?[^,}]*,?', "", text)


def read(client: TestClient, path: str, uuid: str, project: str) -> object:
    answer = client.get(f"{API}/documents/{uuid}{path}")
    if answer.status_code != 200:
        problem = answer.json()
        return answer.status_code, problem["detail"]
    kind = answer.headers["content-type"]
    if "format=npz" in path:
        return {name: held.tolist() for name, held in np.load(io.BytesIO(answer.content)).items()}
    if "format=parquet" in path:
        return parquet.read_table(io.BytesIO(answer.content)).to_pylist()
    if "json" in kind or "text" in kind:
        return plain(answer.text, uuid, project)
    return answer.content


@pytest.mark.parametrize("both", [False, True], ids=["rate", "rate and frame time"])
@pytest.mark.parametrize("form", ["bvh", "htr", "trc", "c3d", "glb"])
@one_kind
def test_every_answer_is_the_same(client: TestClient, tmp_path: Path, form: str, both: bool) -> None:
    """both: the header states twice the rate that the frame time says, which is right."""
    timed, rated = pair(client, form, tmp_path, both=both)
    for path in READS:
        ours, theirs = read(client, path, timed, "timed"), read(client, path, rated, "rated")
        assert theirs == ours, path
    for question in QUESTIONS:
        answers = [
            client.post(f"{API}/xpath", json={**question, "document": [uuid], "limit": 100}) for uuid in (timed, rated)
        ]
        assert answers[0].status_code == 200, answers[0].text
        assert plain(answers[1].text, rated, "rated") == plain(answers[0].text, timed, "timed"), question
