"""The studio: the application in the browser. Its source is TypeScript in `src/`; `build.py` makes `static/` of it."""

import json
from pathlib import Path

STATIC = Path(__file__).parent / "static"
"""What is served: index.html and what it loads."""
PAGES = Path(__file__).parent / "pages.json"
"""The pages of the studio: a row each, for the server and for src/pages.ts."""


def addresses() -> list[str]:
    """Patterns of the routes of the pages in pages.json; "/" is the first page."""
    found = ["/"]
    for row in json.loads(PAGES.read_text(encoding="utf-8")):
        if row["about"] != "one":
            found.append(row["path"])
        if row["about"] != "nothing":
            found.append(f"{row['path']}/{{id}}")
    return found
