"""The studio: the application in the browser. Its source is TypeScript in `src/`; `build.py` makes `static/` of it."""

from pathlib import Path

STATIC = Path(__file__).parent / "static"
"""What is served: index.html and what it loads."""
