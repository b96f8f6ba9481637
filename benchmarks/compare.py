"""Two results of `python -m benchmarks` side by side."""

from __future__ import annotations

import json
import sys
from pathlib import Path


def flat(value: object, name: str = "") -> dict[str, float]:
    if isinstance(value, dict):
        return {key: item for part, inner in value.items() for key, item in flat(inner, f"{name}.{part}").items()}
    return {name.lstrip("."): float(value)} if isinstance(value, int | float) else {}


def main(before: str, after: str) -> None:
    old, new = (flat(json.loads(Path(path).read_text())) for path in (before, after))
    for key in old.keys() & new.keys():
        ratio = new[key] / old[key] if old[key] else float("nan")
        print(f"{key:60} {old[key]:12.4g} {new[key]:12.4g} {ratio:8.2f}x")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("python -m benchmarks.compare BEFORE.json AFTER.json")
    main(sys.argv[1], sys.argv[2])
