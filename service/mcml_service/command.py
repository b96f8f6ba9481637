"""The script `mcml`. It is installed with the library, and needs what only the extra `server` brings."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line, or name the package to install."""
    try:
        from mcml_service.cli import main as run
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("mcml"):
            raise
        sys.exit(f"The command mcml needs {error.name}: pip install 'mcml-repository[server]'")
    run()
