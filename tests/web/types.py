"""The studio's types of the API, from its description. `python -m tests.web.types` writes them; a test compares."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from mcml_service.app import create_app
from mcml_service.settings import Settings
from service.web.build import WEB, install

TYPES = WEB / "src/api/types.gen.ts"
WORDS = {"description", "example", "examples", "title", "summary", "deprecated"}


def without_words(part: Any, *, names: bool = False) -> Any:
    """A description without what only people read. names: the keys of this object are names, none of them words."""
    if isinstance(part, list):
        return [without_words(one) for one in part]
    if not isinstance(part, dict):
        return part
    kept = {key: value for key, value in part.items() if names or key not in WORDS}
    found = {key: without_words(value, names=key in ("properties", "schemas")) for key, value in kept.items()}
    if "content" in found or set(part) == {"description"}:
        found.setdefault("description", "")
    return found


def types() -> str:
    """What openapi-typescript makes of the description. RuntimeError with its words where it refuses."""
    node, environment = install()
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "openapi.json"), Path(folder, "types.ts")
        app = create_app(Settings(database=f"sqlite:///{folder}/types.db"))
        source.write_text(json.dumps(without_words(app.openapi())))
        tool = WEB / "node_modules/openapi-typescript/bin/cli.js"
        command = [*node, str(tool), str(source), "-o", str(target)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr or done.stdout)
        return target.read_text()


if __name__ == "__main__":
    TYPES.write_text(types())
