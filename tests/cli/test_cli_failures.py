"""What goes wrong around the command line: disks, names, addresses. One message, an exit code, never a traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.builders import bvh
from tests.cli.test_cli import environment, mcml  # noqa: F401


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("ls", "--database", "sqlite:///walk.bvh/x.db"), 1),
        (("ls", "--database", "sqlite:///walk.bvh"), 1),
        (("ls", "--database", "nonsense"), 1),
        (("ls", "--database", "postgresql://nobody@127.0.0.1:1/x"), 1),
        (("ls", "--server", "http://["), 1),
        (("ls", "--server", "http://127.0.0.1:1"), 1),
        (("convert", "walk.bvh", "walk.bvh/x.htr"), 1),
        (("db", "backup", "walk.bvh/x.db"), 1),
        (("xpath", "//frame["), 1),
        (("xpath", "sum(//@Tx)"), 0),
        (("xpath", "sum(//@Tx)", "--json"), 0),
        (("ls", "--nope"), 2),
    ],
)
def test_a_message_and_a_code(mcml, words: tuple[str, ...], code: int) -> None:  # noqa: F811
    found, output, errors = mcml(*words)
    assert found == code, errors
    assert code == 0 or errors.strip()
    if "--json" in words:
        assert json.loads(output)["type"] == "number"


def test_an_export_into_no_folder(mcml) -> None:  # noqa: F811
    uuid = json.loads(mcml("import", "walk.bvh", "--json")[1])["documents"][0]["id"]
    code, _, errors = mcml("export", uuid, "--output", "walk.bvh/x/y.bvh")
    assert (code, "walk.bvh" in errors) == (1, True)


def test_names_with_brackets_are_shown_whole(mcml, tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "a[red]b[Hips].bvh").write_bytes(bvh(3, seed=77))
    (tmp_path / "c[bold]d.bvh").write_bytes(b"HIERARCHY\nROOT [bold]\n{\n OFFSET 0 0\n}\n")
    code, output, errors = mcml("import", "a[red]b[Hips].bvh", "c[bold]d.bvh")
    assert code == 3, errors
    assert "a[red]b[Hips]" in output
    assert "c[bold]d.bvh:5: OFFSET of joint '[bold]' needs 3 numbers" in output
    assert "a[red]b[Hips]" in mcml("ls")[1]


def test_names_of_any_bytes(mcml, tmp_path: Path) -> None:  # noqa: F811
    for name, encoding in (("걸음", "cp949"), ("für", "latin-1"), ("달리기", "utf-8")):
        Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name.encode(encoding) + b".bvh")).write_bytes(
            bvh(3, seed=len(name) + len(encoding))
        )
    (tmp_path / "bad.bvh").unlink()
    names = {item["name"] for item in json.loads(mcml("import", ".", "--json")[1])["documents"]}
    assert names >= {"걸음", "달리기", "für"}
    # A terminal that can show none of them.
    shown = subprocess.run(
        [sys.executable, "-m", "service.cli", "ls", "--json"],
        capture_output=True,
        cwd=tmp_path,
        env=environment(tmp_path) | {"PYTHONIOENCODING": "ascii"},
    )
    assert shown.returncode == 0, shown.stderr
    assert names == {item["name"] for item in json.loads(shown.stdout.decode("unicode_escape"))["items"]}


@pytest.mark.parametrize(
    "words",
    [
        ("ls",),
        ("ls", "--json"),
        ("show", "{id}"),
        ("xpath", "//frame"),
        ("xpath", "//frame", "--json"),
        ("export", "{id}", "-o", "-"),
        ("doctor",),
        ("--help",),
    ],
)
def test_nobody_reads_the_output(mcml, tmp_path: Path, words: tuple[str, ...]) -> None:  # noqa: F811
    uuid = json.loads(mcml("import", "walk.bvh", "--json")[1])["documents"][0]["id"]
    read_end, write_end = os.pipe()
    os.close(read_end)
    done = subprocess.run(
        [sys.executable, "-m", "service.cli", *(word.format(id=uuid) for word in words)],
        stdout=write_end,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env=environment(tmp_path),
    )
    os.close(write_end)
    assert (done.returncode, done.stderr) == (0, b"")
