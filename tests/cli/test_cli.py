"""The command line as a newcomer uses it: on a store, against a server, on files alone."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mcml_service.cli import main
from tests.builders import ASF, HTR, MCML, amc, bvh

Mcml = Callable[..., tuple[int, str, str]]


def environment(folder: Path) -> dict[str, str]:
    """What a command sees: this checkout, and a store of its own in the folder."""
    root = Path(__file__).resolve().parents[2]
    return {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(root), "XDG_DATA_HOME": str(folder / "home")}


@pytest.fixture
def mcml(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Mcml:
    """Runs `mcml` in this process, for it takes a second to start; answers (exit code, output, errors)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MCML_DATABASE", raising=False)

    def run(*words: str, **more: str) -> tuple[int, str, str]:
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["mcml", *words])
            for name, value in (environment(tmp_path) | more).items():
                patch.setenv(name, value)
            with pytest.raises(SystemExit) as ended:
                main()
        output, errors = capsys.readouterr()
        return int(ended.value.code or 0), output, errors

    (tmp_path / "walk.bvh").write_bytes(bvh(30))
    (tmp_path / "leg.asf").write_bytes(ASF)
    (tmp_path / "leg.amc").write_bytes(amc(4))
    (tmp_path / "two.htr").write_bytes(HTR)
    (tmp_path / "hand.mcml").write_bytes(MCML)
    (tmp_path / "bad.bvh").write_bytes(bvh(3)[:-40])
    return run


def test_a_first_session(mcml: Mcml, tmp_path: Path) -> None:
    code, output, _ = mcml("import", "walk.bvh", "--label", "walk:1-20", "--property", "age=23 year", "--json")
    assert code == 0
    uuid = json.loads(output)["documents"][0]["id"]
    assert uuid in mcml("ls")[1]
    assert "age = 23 year" in mcml("show", uuid)[1]
    assert mcml("xpath", "//frame[motion_name='walk']", "--as", "count")[1].strip() == "20"
    assert mcml("label", uuid, "left-arm-abduction:5-9")[0] == 0
    code, output, _ = mcml("xpath", "//frame[motion_name='left-arm-abduction']/@id", "--as", "json")
    assert [line.split()[-1] for line in output.splitlines()] == ["5", "6", "7", "8", "9"]
    assert mcml("export", uuid, "--format", "bvh", "--output", "out.bvh")[0] == 0
    assert (tmp_path / "out.bvh").read_bytes() == bvh(30)
    assert mcml("export", uuid, "--format", "mcml", "-o", "-")[1].startswith("<?xml")
    assert "skipped" in mcml("import", "walk.bvh")[1]


def test_numbers(mcml: Mcml, tmp_path: Path) -> None:
    mcml("import", "walk.bvh")
    code, output, _ = mcml("numbers", "walk", "--bone", "Head", "--quantity", "time", "--first", "3", "--last", "4")
    assert code == 0
    head, *rows = output.splitlines()
    assert head == "frame,id,time,Head.Rz,Head.Rx,Head.Ry,mo:time"
    assert [row.split(",")[:2] for row in rows] == [["3", "3"], ["4", "4"]]
    assert [float(rows[0].split(",")[place]) for place in (2, -1)] == [0.0, 2 * 0.0083333]
    assert mcml("numbers", "walk", "some.npz", "--quantity", "height:Head")[0] == 0
    assert np.load(tmp_path / "some.npz")["units"].tolist() == ["m"]
    code, _, errors = mcml("numbers", "walk", "some.txt")
    assert code == 2
    assert "some.txt" in errors
    code, _, errors = mcml("numbers", "walk", "--quantity", "altitude:Head")
    assert code == 2
    assert "no quantity 'altitude'" in errors


def test_a_folder_with_a_bad_file_is_done_in_part(mcml: Mcml) -> None:
    code, output, _ = mcml("import", ".")
    assert code == 3
    assert "4 stored, 1 failed" in output
    assert "bad.bvh" in output
    code, output, _ = mcml("import", ".")
    assert "0 stored, 1 failed" in output


def test_convert_needs_no_store(mcml: Mcml, tmp_path: Path) -> None:
    assert mcml("convert", "leg.asf", "leg.amc", "out.bvh", "--frame-time", "0.01")[0] == 0
    assert b"Frame Time: 0.01" in (tmp_path / "out.bvh").read_bytes()
    assert mcml("convert", "walk.bvh", "walk.amc")[0] == 0
    assert (tmp_path / "walk.asf").exists()
    assert mcml("convert", "walk.bvh", "same.bvh")[0] == 0
    assert (tmp_path / "same.bvh").read_bytes() == bvh(30)
    assert mcml("convert", "two.htr", "two.mcml")[0] == 0
    assert mcml("convert", "two.mcml", "back.htr")[0] == 0
    assert mcml("validate", "two.mcml", "back.htr", "same.bvh")[0] == 0
    assert not (tmp_path / "home").exists()


def test_errors_are_one_message_and_exit_one(mcml: Mcml, tmp_path: Path) -> None:
    for words in (
        ("convert", "bad.bvh", "out.htr"),
        ("convert", "nothing.bvh", "out.htr"),
        ("convert", "walk.bvh", "out.xyz"),
        ("validate", "bad.bvh"),
        ("show", "nothing"),
        ("xpath", "//frame["),
        ("ls", "--server", "http://127.0.0.1:9"),
        ("ls", "--database", "nonsense"),
    ):
        code, output, errors = mcml(*words)
        assert code == 1, words
        assert output + errors
    assert not (tmp_path / "out.htr").exists()
    assert not list(tmp_path.glob("*.part"))


def test_backup_and_restore(mcml: Mcml) -> None:
    assert mcml("import", ".")[0] == 3
    assert mcml("db", "backup", "copy.db")[0] == 0
    assert mcml("db", "backup", "copy.db")[0] == 1
    assert "4 documents" in mcml("db", "restore", "copy.db", "--database", "sqlite:///other.db")[1]
    assert mcml("db", "check", "--database", "sqlite:///other.db")[0] == 0
    assert mcml("ls", "--database", "sqlite:///other.db", "--json")[1] == mcml("ls", "--json")[1]
    assert mcml("db", "restore", "copy.db", "--database", "sqlite:///other.db")[0] == 1


def test_tokens(mcml: Mcml) -> None:
    secret = mcml("token", "add", "farm")[1].splitlines()[0]
    assert secret.startswith("mcml_")
    listed = mcml("token", "list")[1]
    assert "farm" in listed
    assert secret not in listed
    assert mcml("token", "add", "farm")[0] == 1
    assert mcml("token", "revoke", "farm")[0] == 0
    assert "farm" not in mcml("token", "list")[1]


@pytest.mark.slow
def test_the_same_commands_on_a_server(mcml: Mcml, tmp_path: Path) -> None:
    import os
    import socket
    import time
    import urllib.request

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"http://127.0.0.1:{port}"
    environment = os.environ | {"XDG_DATA_HOME": str(tmp_path / "served")}
    server = subprocess.Popen([sys.executable, "-m", "mcml_service.cli", "serve", "--port", str(port)], env=environment)
    try:
        for _ in range(300):
            try:
                urllib.request.urlopen(f"{address}/readyz")
                break
            except OSError:
                time.sleep(0.1)
        code, output, _ = mcml("import", "walk.bvh", "--label", "walk", "--server", address, "--json")
        assert code == 0
        uuid = json.loads(output)["documents"][0]["id"]
        assert uuid in mcml("ls", "--server", address)[1]
        assert mcml("xpath", "//frame[motion_name='walk']", "--as", "count", "--server", address)[1].strip() == "30"
        assert mcml("label", uuid, "hop:2-3", "--server", address)[0] == 0
        assert mcml("export", uuid, "--output", "served.bvh", "--server", address)[0] == 0
        assert (tmp_path / "served.bvh").read_bytes() == bvh(30)
        assert mcml("show", "nothing", "--server", address)[0] == 1
        assert mcml("import", "bad.bvh", "--server", address)[0] == 1
    finally:
        server.terminate()
        assert server.wait(10) is not None
