"""Variables of the environment that look like settings and are none."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import uvicorn
from typer.testing import CliRunner

from mcml_service import app as application
from mcml_service.cli import app
from mcml_service.settings import OTHERS, Settings, unknown_variables

ROOT = Path(__file__).resolve().parents[2]


def test_the_nearest_name_is_told() -> None:
    assert unknown_variables(["MCML_DATABSE", "PATH", "MCML_PORT", "MCML_SHARED"]) == [
        "MCML_DATABSE is no setting. Did you mean MCML_DATABASE?"
    ]
    (told,) = unknown_variables(["mcml_trusted_proxys"])
    assert told == "mcml_trusted_proxys is no setting. Did you mean MCML_TRUSTED_PROXIES?"
    assert unknown_variables(["MCML_ZZZZZZ"]) == ["MCML_ZZZZZZ is no setting. See docs/settings.md."]
    assert unknown_variables([f"MCML_{name.upper()}" for name in Settings.model_fields]) == []


def test_variables_of_tests_and_measurements_are_known() -> None:
    known = {f"MCML_{name.upper()}" for name in Settings.model_fields}
    scripts = (file for folder in ("tests", "benchmarks") for file in ROOT.glob(f"{folder}/**/*.py"))
    files = [*scripts, ROOT / "Makefile", ROOT / "docker-compose.yml"]
    read = re.compile(r"""(?:environ(?:\.get\(|\[)|getenv\(|\$\{)["']?(MCML_[A-Z_]+)""")
    named = {name for file in files for name in read.findall(file.read_text(encoding="utf-8"))}
    assert named - known - OTHERS == set()
    assert OTHERS.isdisjoint(known)


def test_a_start_and_the_doctor_tell_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = "Did you mean MCML_QUERY_SECONDS?"
    monkeypatch.setenv("MCML_QUERY_SECOND", "5")
    monkeypatch.setattr(uvicorn, "run", lambda *given, **named: None)
    words = ["--database", f"sqlite:///{tmp_path}/store.db"]
    started = CliRunner().invoke(app, ["serve", "--port", "0", *words])
    assert started.exit_code == 0
    assert said in started.output
    looked = CliRunner().invoke(app, ["doctor", *words])
    assert looked.exit_code == 1
    assert said in looked.output
    monkeypatch.delenv("MCML_QUERY_SECOND")
    assert "Did you mean" not in CliRunner().invoke(app, ["doctor", *words]).output


def test_an_application_that_another_program_serves_logs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setenv("MCML_DATABASE", f"sqlite:///{tmp_path}/store.db")
    monkeypatch.setenv("MCML_PRT", "1")
    application.app_from_environment()
    assert "MCML_PRT is no setting. Did you mean MCML_PORT?" in caplog.text
