"""What goes wrong around the command line: disks, names, addresses. One message, an exit code, never a traceback."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests import fuzz
from tests.builders import bvh
from tests.cli.test_cli import Mcml, environment, mcml  # noqa: F401


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
        [sys.executable, "-m", "mcml_service.cli", "ls", "--json"],
        capture_output=True,
        cwd=tmp_path,
        env=environment(tmp_path) | {"PYTHONIOENCODING": "ascii"},
    )
    assert shown.returncode == 0, shown.stderr
    assert names == {item["name"] for item in json.loads(shown.stdout.decode("unicode_escape"))["items"]}


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    fuzz.share(
        [
            ("ls", "--json"),
            ("ls",),
            ("xpath", "//frame"),
            ("show", "{id}"),
            ("export", "{id}", "-o", "-"),
            ("xpath", "//frame", "--json"),
            ("--help",),
            ("doctor",),
        ],
        2,
    ),
)
def test_nobody_reads_the_output(mcml, tmp_path: Path, words: tuple[str, ...]) -> None:  # noqa: F811
    uuid = json.loads(mcml("import", "walk.bvh", "--json")[1])["documents"][0]["id"]
    read_end, write_end = os.pipe()
    os.close(read_end)
    done = subprocess.run(
        [sys.executable, "-m", "mcml_service.cli", *(word.format(id=uuid) for word in words)],
        stdout=write_end,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env=environment(tmp_path),
    )
    os.close(write_end)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.slow
def test_an_import_goes_on_where_nobody_reads_what_it_says(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    for number in range(6):
        (tmp_path / f"take{number}.bvh").write_bytes(bvh(3, seed=number))
    read_end, write_end = os.pipe()
    os.close(read_end)
    command = [sys.executable, "-m", "mcml_service.cli", "import", *(f"take{number}.bvh" for number in range(6))]
    done = subprocess.run(command, stdout=write_end, stderr=subprocess.PIPE, cwd=tmp_path, env=environment(tmp_path))
    os.close(write_end)
    assert (done.returncode, done.stderr) == (0, b"")
    assert json.loads(mcml("ls", "--json")[1])["total"] == 6


def test_a_port_that_is_taken_or_none_is_one_sentence(mcml: Mcml) -> None:  # noqa: F811
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, _, errors = mcml("serve", "--port", str(port))
    assert (code, errors.count("\n")) == (1, 2)
    assert f"127.0.0.1:{port}" in errors
    for wrong in ("99999", "-1"):
        code, _, errors = mcml("serve", "--port", wrong)
        assert (code, "port" in errors.lower(), "Traceback" in errors) == (1, True, False)


def test_a_folder_without_anything_readable_is_no_success(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "a.txt").write_text("no motion")
    code, _, errors = mcml("import", "notes")
    assert (code, "Files end in" in errors) == (1, True)


def test_nothing_is_overwritten(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    one = json.loads(mcml("import", "walk.bvh", "--json")[1])["documents"][0]["id"]
    other = json.loads(mcml("import", "leg.asf", "leg.amc", "--name", "walk", "--json")[1])["documents"][0]["id"]
    (tmp_path / "out").mkdir()
    assert mcml("export", one, other, "--format", "csv", "-o", "out")[0] == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(["walk.csv", f"walk-{other[-6:]}.csv"])
    before = (tmp_path / "out" / "walk.csv").read_bytes()
    code, _, errors = mcml("export", other, "--format", "csv", "-o", "out")
    assert (code, "--force" in errors, (tmp_path / "out" / "walk.csv").read_bytes()) == (1, True, before)
    assert mcml("export", other, "--format", "csv", "-o", "out", "--force")[0] == 0
    assert (tmp_path / "out" / "walk.csv").read_bytes() != before
    walk = (tmp_path / "walk.bvh").read_bytes()
    assert mcml("convert", "walk.bvh", "walk.bvh", "--force")[0] == 1
    assert (tmp_path / "walk.bvh").read_bytes() == walk
    assert mcml("convert", "walk.bvh", "two.htr")[0] == 1
    assert mcml("convert", "walk.bvh", "two.htr", "--force")[0] == 0


def test_a_batch_goes_on_past_a_refusal(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    mcml("import", "leg.asf", "leg.amc", "walk.bvh", "--project", "all")
    assert mcml("set", "walk", "--unit", "cm")[0] == 0
    code, _, errors = mcml("export", "--project", "all", "--unit", "mm", "--format", "bvh", "-o", "out")
    assert (code, errors.count("mcml: leg "), (tmp_path / "out" / "walk.bvh").exists()) == (3, 1, True)


def test_what_deletes_or_moves_shows_its_matches_first(mcml: Mcml) -> None:  # noqa: F811
    mcml("import", "walk.bvh", "two.htr", "--project", "gait")
    code, output, _ = mcml("delete", "--project", "gait")
    assert (code, "walk" in output, "--yes" in output) == (0, True, True)
    assert json.loads(mcml("ls", "--json")[1])["total"] == 2
    assert mcml("move", "lab", "walk", "--yes")[0] == 0
    assert [item["name"] for item in json.loads(mcml("ls", "--project", "lab", "--json")[1])["items"]] == ["walk"]
    assert mcml("delete", "--xpath", "//frame", "--yes")[0] == 0
    assert json.loads(mcml("ls", "--json")[1])["total"] == 0
    gone = json.loads(mcml("ls", "--deleted", "--json")[1])["items"][0]
    assert mcml("restore", gone["name"])[0] == 0
    assert mcml("show", gone["name"])[0] == 0
    assert mcml("delete", "nobody", "--yes")[0] == 1
    assert mcml("delete")[0] == 2


def test_what_is_purged_may_be_chosen(mcml: Mcml) -> None:  # noqa: F811
    mcml("import", "walk.bvh", "--project", "gait", "--label", "walk:1-9")
    mcml("import", "two.htr", "--project", "gait")
    code, output, _ = mcml("purge", "--project", "gait", "--motion-name", "walk")
    assert (code, "walk" in output, "two" in output) == (0, True, False)
    assert mcml("purge", "--project", "gait", "--xpath", "//frame[motion_name='walk']", "--yes")[0] == 0
    assert [item["name"] for item in json.loads(mcml("ls", "--json")[1])["items"]] == ["two"]
    assert mcml("purge")[0] == 1


def test_the_first_account_is_an_owners(mcml, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    """Neither an invitation nor a guest's account comes first."""
    monkeypatch.setattr("mcml_service.cli.accounts._ask_password", lambda: "four words in a row")
    for words in (("account", "invite"), ("account", "add", "lee"), ("account", "add", "lee", "--role", "member")):
        code, _, errors = mcml(*words)
        assert (code, "your own account first" in " ".join(errors.split())) == (1, True), (words, errors)
    assert mcml("account", "add", "kim", "--role", "owner")[0] == 0
    assert mcml("account", "invite")[0] == 0
