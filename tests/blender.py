"""Blender for tests: the program, or its module `bpy` in an environment of its own.

`python -m tests.blender install` makes that environment beside the project's (400 MB, Python 3.11 alone); its packages
do not fit those of the project. Tests with Blender are skipped without either.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import venv
from functools import cache
from pathlib import Path

MODULE = "bpy==4.5.15"
HOME = Path(__file__).resolve().parents[1] / ".venv-blender"
_PROGRAM = HOME / "bin" / "blender"
_MISSING = "Blender is not here: python -m tests.blender install, or apt-get install blender python3-numpy"
_SCRIPT = '''#!{python}
"""The command line of Blender as far as tests use it: --python-expr TEXT, -P FILE."""
import runpy, sys, traceback
import bpy
bpy.ops.wm.read_factory_settings()
words = sys.argv
try:
    if "--python-expr" in words:
        exec(words[words.index("--python-expr") + 1])
    if "-P" in words:
        runpy.run_path(words[words.index("-P") + 1], run_name="__main__")
except Exception:
    traceback.print_exc()
    sys.exit(3)
'''


@cache
def find_blender() -> str | None:
    """The program that takes Blender's command line; None where there is none."""
    return shutil.which("blender") or (str(_PROGRAM) if _PROGRAM.exists() else None)


@cache
def why_not() -> str:
    """Why Blender cannot read glTF here; empty where it can."""
    program = find_blender()
    if program is None:
        return _MISSING
    asked = [program, "-b", "--factory-startup", "--python-expr", "import numpy; print('numpy is there')"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return "" if "numpy is there" in done.stdout else "Blender has no NumPy, which its glTF reader needs"


def install() -> None:
    """Make the environment, and a program in it that is called as Blender is."""
    venv.create(HOME, with_pip=True, clear=True)
    python = HOME / "bin" / "python"
    subprocess.run([str(python), "-m", "pip", "install", "--quiet", MODULE], check=True)
    _PROGRAM.write_text(_SCRIPT.format(python=python))
    _PROGRAM.chmod(0o755)


if __name__ == "__main__":
    if sys.argv[1:] != ["install"]:
        sys.exit("usage: python -m tests.blender install")
    install()
