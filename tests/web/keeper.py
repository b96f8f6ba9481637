"""The checks of the studio's source: `python -m tests.web.keeper [name ...]`, a part of `make check`.

Each is a program of service/web/package.json. `install` only installs their packages; `fix` mends what can be mended by
a program.
"""

from __future__ import annotations

import subprocess
import sys

from service.web.build import WEB, install

MODULES = "node_modules"
CHECKS = {
    "types": [f"{MODULES}/typescript-native/bin/tsc", "--noEmit"],
    "layout": [f"{MODULES}/prettier/bin/prettier.cjs", "--check", "--log-level", "warn", "."],
    "style": [f"{MODULES}/eslint/bin/eslint.js", "--max-warnings", "0", "."],
    "layers": [f"{MODULES}/dependency-cruiser/bin/dependency-cruise.mjs", "--output-type", "err", "src"],
}


FIXES = (
    [f"{MODULES}/eslint/bin/eslint.js", "--fix", "."],
    [f"{MODULES}/prettier/bin/prettier.cjs", "--write", "--log-level", "warn", "."],
)


def run(command: list[str]) -> int:
    """Run a program of node_modules; its words go to the terminal. Return what it ended with."""
    node, environment = install()
    return subprocess.run([*node, *command], cwd=WEB, env=environment, check=False).returncode


if __name__ == "__main__":
    asked = sys.argv[1:]
    if asked == ["install"]:
        install()
    elif asked == ["fix"]:
        for fix in FIXES:
            run(fix)
    elif found := [name for name in asked or CHECKS if run(CHECKS[name])]:
        sys.exit(f"studio: {', '.join(found)}")
