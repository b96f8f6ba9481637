"""A page of the studio is a row, a component and words in all languages: all that leads to it follows."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from service.web.build import WEB, install
from tests.drills.patched_copy import PatchedCopy, count_named_files

ROW = (
    ',\n  { "name": "juggling", "path": "/juggling", "about": "any", "title": "label.juggling", '
    '"go": "button.goJuggling", "key": "U", "icon": "chart", "rail": "top", "file": "juggling/JugglingPage" }'
)
COMPONENT = """/** A page about juggling. */
import { w } from "../../words";

export function JugglingPage({ id }: { id: string }) {
  return (
    <h1>
      {w("label.juggling")} {id}
    </h1>
  );
}
"""
SERVED = """
from mcml_service.api.studio import STATIC
from mcml_service.storage.database import Database
from tests.builders import served
import mcml

mcml.open("store.db").close()
STATIC.mkdir()
(STATIC / "index.html").write_text("the studio")
with served(Database("sqlite:///store.db")) as client:
    assert [client.get(path).status_code for path in ("/juggling", "/juggling/1", "/jugglign")] == [200, 200, 404]
"""
UNITS = ["src/pages.test.ts", "src/shell/App.test.tsx", "src/words/words.test.ts"]
"""Tests of each row: router, component, rail, bar, keys, palette, words."""


@pytest.fixture
def copy(tmp_path: Path) -> PatchedCopy:
    made = PatchedCopy(tmp_path / "copy")
    web = made.folder / "service/web"
    shutil.copytree(WEB / "src", web / "src")
    (web / "node_modules").symlink_to(WEB / "node_modules")
    return made


def run_node(copy: PatchedCopy, *command: str) -> str:
    node, environment = install()
    web = copy.folder / "service/web"
    done = subprocess.run([*node, *command], cwd=web, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("among_others", [False, pytest.param(True, marks=pytest.mark.fuzz)])
def test_a_page_of_the_studio(copy: PatchedCopy, among_others: bool) -> None:
    """In `make fuzz` with its types, and beside the tests of all other pages."""
    copy.put("service/web/pages.json", "\n]", ROW)
    copy.add("service/web/src/panels/juggling/JugglingPage.tsx", COMPONENT)
    copy.put(
        "service/web/src/words/en.ts",
        '  "label.library": "Library",',
        '  "label.juggling": "Juggling", "button.goJuggling": "Go to juggling",\n',
    )
    copy.put(
        "service/web/src/words/ko.ts",
        '  "label.library": "라이브러리",',
        '  "label.juggling": "저글링", "button.goJuggling": "저글링으로 가기",\n',
    )
    copy.put(
        "service/web/src/words/ja.ts",
        '  "label.library": "ライブラリ",',
        '  "label.juggling": "ジャグリング", "button.goJuggling": "ジャグリングへ移動",\n',
    )
    assert len(copy.touched) == count_named_files("a page of the studio"), sorted(copy.touched)
    if among_others:
        run_node(copy, "node_modules/typescript-native/bin/tsc", "--noEmit", "-p", "tsconfig.build.json")
    chosen = [] if among_others else ["--testNamePattern=juggling"]
    said = run_node(copy, "node_modules/vitest/vitest.mjs", "run", "--no-color", "--reporter=verbose", *UNITS, *chosen)
    for name in ("its address", "its icon in the rail", "the bar has its title", "its key, and from the palette"):
        assert any("juggling" in line and name in line for line in said.splitlines()), name
    copy.run("-c", SERVED)
