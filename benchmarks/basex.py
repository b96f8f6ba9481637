"""BaseX (Debian package `basex`) as a peer: one JVM a script, text and attribute index on, its own clock."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

_CREATED = re.compile(r"Database '(\w+)' created in ([\d.]+) ms")
_TOTAL = re.compile(r"^Total Time: ([\d.]+) ms", re.MULTILINE)


@dataclass
class BaseX:
    """What a script took. created: milliseconds by database. queries: milliseconds of each XQUERY, in order.
    bytes: size on disk by database."""

    created: dict[str, float] = field(default_factory=dict)
    queries: list[float] = field(default_factory=list)
    bytes: dict[str, int] = field(default_factory=dict)


def available() -> bool:
    return shutil.which("basex") is not None


def run(commands: list[str]) -> BaseX:
    """Run database commands one after the other."""
    with tempfile.TemporaryDirectory() as home:
        script = Path(home) / "commands.bxs"
        script.write_text("\n".join(["SET TEXTINDEX true", "SET ATTRINDEX true", *commands]))
        done = subprocess.run(
            ["basex", "-V", "-c", str(script)],
            capture_output=True,
            text=True,
            env={"BASEX_JVM": "-Xmx8g", "PATH": "/usr/bin:/bin", "HOME": home},
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"BaseX failed: {done.stdout[-2000:]}{done.stderr[-2000:]}")
        result = BaseX({name: float(time) for name, time in _CREATED.findall(done.stdout)})
        result.queries = [float(time) for time in _TOTAL.findall(done.stdout)]
        for database in (Path(home) / "basex" / "data").glob("*/"):
            size = sum(file.stat().st_size for file in database.rglob("*") if file.is_file())
            result.bytes[database.name] = size
        return result
