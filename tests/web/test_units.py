"""The studio's pure parts, tested in their own language: `vitest` over `service/web/src/**/*.test.ts`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from service.web.build import WEB, install
from tests.web import matching_cases
from tests.web.thumbnail_cases import cases

ONE_THREAD = ["--pool=threads", "--no-isolate", "--max-workers=1"]
"""Half of the time that a process for each file takes."""


def vitest(*files: str, **environment: Any) -> str:
    """What it says of the tests in these files, or in all. AssertionError with its words where one fails."""
    node, usual = install()
    command = [*node, "node_modules/vitest/vitest.mjs", "run", "--no-color", "--reporter=default", *ONE_THREAD, *files]
    stated = {name: str(value) for name, value in environment.items()}
    done = subprocess.run(command, cwd=WEB, env=usual | stated, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_units(tmp_path: Path) -> None:
    """All pass, and reach 80 % of the lines of `state/` and `motion/` (vitest.config.ts)."""
    thumbnails = tmp_path / "thumbnails.json"
    thumbnails.write_text(json.dumps(cases(range(10))))
    matching = tmp_path / "matching.json"
    matching.write_text(json.dumps(matching_cases.cases()))
    assert "passed" in vitest("--coverage", MCML_THUMBNAILS=thumbnails, MCML_MATCHING=matching)
