"""Numbers near the largest double: stored as they are, and never written or kept as what is no number."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from mcml.errors import ConversionError
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.storage.database import Database
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, one_kind, store, upload

API = "/api/v1"
CASES: dict[str, dict[str, bytes]] = {
    "values": {"a.bvh": re.sub(rb"(?<= )-?\d+\.\d{4}(?= )", b"-1.7e308", bvh(40))},
    "both ends": {"a.bvh": re.sub(rb"(?<= )(-?)\d+\.\d{4}(?= )", rb"\g<1>1.7e308", bvh(40))},
    "offsets": {"a.bvh": bvh(5).replace(b"OFFSET 0.00 10.5 0.00", b"OFFSET 1e308 -1.7e308 1e308")},
    "markers": {"a.trc": TRC.replace(b"273.71817", b"1e308").replace(b"-56.52053", b"-1.7e308")},
    "times": {"a.trc": TRC.replace(b"0.083", b"1e308").replace(b"0.092", b"-1e308")},
    "rate": {"a.trc": TRC.replace(b"120.00\t120.00\t4", b"1e-320\t120.00\t4")},
    "segments": {"a.htr": HTR.replace(b"\t0.5\t0", b"\t1e308\t0").replace(b"250.0", b"-1.7e308")},
    "bones": {"a.asf": ASF.replace(b"7.34031", b"1.7e308"), "a.amc": amc(3).replace(b"17.5", b"1.7e308")},
    "elements": {"a.mcml": MCML.replace(b'"1.5"', b'"1e308"').replace(b'Rx="20"', b'Rx="-1.7e308"')},
    "long frames": {"a.bvh": bvh(5).replace(b"0.0083333", b"1e308")},
    "short frames": {"a.bvh": bvh(5).replace(b"0.0083333", b"1e-308")},
}
NO_NUMBER = re.compile(rb"(?i)(?<![a-z])(inf(inity)?|nan)(?![a-z])")


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("case", CASES)
@one_kind
def test_exports_are_finite_or_refused(database: Database, case: str) -> None:
    uuid = store(database, CASES[case])[0]
    for name in ("bvh", "asf", "amc", "htr", "trc", "c3d", "mcml", "csv"):
        try:
            with database.read() as tx:
                export = export_document(tx, tx.documents.get(uuid), ExportOptions(name, original=False))
                content = b"".join(export.content)
        except ConversionError:
            continue
        assert name == "c3d" or not NO_NUMBER.search(content), name


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@one_kind
def test_edits_that_lead_beyond_are_refused(client: TestClient) -> None:
    edits: list[dict[str, object]] = [
        {"do": "adjust", "first": 1, "last": 2, "channels": ["Tx", "Ty", "Rx"], "factor": 100},
        {"do": "smooth", "first": 1, "last": 3, "seconds": 0.1},
        {"do": "resample", "rate": 77},
        {"do": "mirror", "first": 1, "last": 2},
        {"do": "low-pass", "first": 1, "last": 3, "hertz": 6},
        {"do": "despike", "first": 1, "last": 3},
        {"do": "unroll"},
    ]
    refused: dict[str, set[str]] = {}
    for case, files in CASES.items():
        uuid = upload(client, files)["documents"][0]["id"]  # type: ignore[index]
        asked = [("POST", f"/documents/{uuid}/frames", {"edits": [edit]}) for edit in edits]
        asked += [("POST", "/compose", {"name": "x", "segments": [{"document": uuid}, {"document": uuid}]})]
        for method, address, body in asked:
            answer = client.request(method, f"{API}{address}", json=body, headers={"if-match": "*"})
            assert answer.status_code in (200, 201, 404, 422), (case, body, answer.text)
            if "beyond the largest" in answer.text or "not finite" in answer.text:
                refused.setdefault(case, set()).add(str(body))
        content = client.get(f"{API}/documents/{uuid}/mcml").content
        assert not NO_NUMBER.search(content), case
    assert {"values", "markers", "elements"} <= set(refused)
    assert any("resample" in body for body in refused["both ends"])


@pytest.mark.slow
def test_nothing_is_printed(tmp_path: Path) -> None:
    env = os.environ | {"MCML_DATABASE": f"sqlite:///{tmp_path / 'store.db'}", "MCML_IMPORT_PROCESSES": "1"}
    names = []
    for number, files in enumerate(CASES.values()):
        for name, content in files.items():
            path = tmp_path / f"{number}{name}"
            path.write_bytes(content)
            names.append(path.name)
    for command in (["import", *names], ["convert", names[0], "out.htr"], ["convert", names[2], "out.amc"]):
        words = [sys.executable, "-m", "mcml_service.cli", *command]
        done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, check=False)
        assert "Warning" not in done.stderr, done.stderr
        assert "Traceback" not in done.stderr, done.stderr
