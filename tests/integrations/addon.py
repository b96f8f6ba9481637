"""A repository that is served, the add-on in a Blender, and where bones should be there."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from tests.blender import find_blender

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "integrations" / "blender" / "mcml_repository.py"
SCRIPT = Path(__file__).with_name("blender_uses.py")

MIXED = """HIERARCHY
ROOT Hips
{
 OFFSET 1.5 90 -2
 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
 JOINT Spine
 {
  OFFSET 0 10 1
  CHANNELS 3 Xrotation Yrotation Zrotation
  JOINT Neck
  {
   OFFSET 0 20 0
   CHANNELS 6 Xposition Yposition Zposition Yrotation Zrotation Xrotation
   End Site
   {
    OFFSET 0 8 2
   }
  }
 }
 JOINT LeftUpLeg
 {
  OFFSET 9 -2 0
  CHANNELS 1 Xrotation
  JOINT LeftLeg
  {
   OFFSET 0 -40 0
   CHANNELS 2 Zrotation Xrotation
   End Site
   {
    OFFSET 0 -38 0
   }
  }
 }
}
MOTION
Frames: 40
Frame Time: 0.025
"""
"""Joints of many orders, some with few channels, some that move in their parents."""


def mixed() -> bytes:
    rng = np.random.default_rng(5)
    values = np.cumsum(rng.normal(0, 9, (40, 18)), axis=0)
    values[:, :3] += (0, 90, 0)
    values[:, 9:12] = rng.normal((0, 20, 0), 1, (40, 3))
    return (MIXED + "\n".join(" ".join(f"{value:.4f}" for value in row) for row in values) + "\n").encode()


@dataclass
class Served:
    url: str
    token: str

    def client(self) -> httpx.Client:
        return httpx.Client(base_url=f"{self.url}/api/v1", headers=self.headers(), timeout=30)

    def headers(self) -> dict[str, str]:
        return {"authorization": f"Bearer {self.token}"}

    def upload(self, files: dict[str, bytes], **form: Any) -> str:
        with self.client() as client:
            answer = client.post("/documents", files=[("file", item) for item in files.items()], data=form)
            answer.raise_for_status()
            return str(answer.json()["documents"][0]["id"])

    def get(self, path: str, **parameters: Any) -> Any:
        with self.client() as client:
            return client.get(path, params=parameters).raise_for_status().json()

    def numbers(self, document: str, **parameters: Any) -> np.ndarray:
        with self.client() as client:
            answer = client.get(f"/documents/{document}/frames", params={"format": "block", **parameters})
            shape = [int(length) for length in answer.raise_for_status().headers["x-mcml-shape"].split(",")]
            return np.frombuffer(answer.content, "<f8").reshape(shape)


class Blender:
    """One in the background that runs the steps of test after test, each from factory settings: its start takes longer
    than most of them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None

    def __call__(self, served: Served, *steps: Any) -> list[Any]:
        """What each step answered, after the preferences are set."""
        if self.process is None:
            self.process = self._start()
        asked = {"addon": str(ADDON), "steps": [("set_server", served.url, served.token), *steps]}
        try:
            self.process.stdin.write(json.dumps(asked) + "\n")  # type: ignore[union-attr]
            self.process.stdin.flush()  # type: ignore[union-attr]
            answered: list[Any] = json.loads(self.answers.readline())
        except BaseException:
            self.close()  # The next test has another one.
            print((self.folder / "log").read_text()[-6000:])
            raise
        return answered[1:]

    def _start(self) -> subprocess.Popen[str]:
        # Answers have a pipe of their own: Blender prints what it likes.
        ours, theirs = os.pipe()
        self.answers = os.fdopen(ours)
        command = [str(find_blender()), "-b", "--factory-startup", "--python-exit-code", "3", "-P", str(SCRIPT)]
        folders = {f"BLENDER_USER_{name}": str(self.folder / name.lower()) for name in ("SCRIPTS", "CONFIG")}
        with open(self.folder / "log", "w") as log:
            started = subprocess.Popen(
                [*command, "--", str(theirs)], stdin=subprocess.PIPE, stdout=log, stderr=log, text=True,
                pass_fds=[theirs], env={**os.environ, **folders},
            )  # fmt: skip
        os.close(theirs)
        return started

    def close(self) -> None:
        if self.process is not None:
            try:
                self.process.communicate(timeout=5)  # seconds; it ends with its input
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
            self.answers.close()
            self.process = None


def in_blender(positions: np.ndarray, up: str, metres: float) -> np.ndarray:
    """Positions of a document as Blender's world has them."""
    turned = {
        "Y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        "-Y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        "Z": np.eye(3),
        "X": [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
    }[up]
    return positions @ np.array(turned).T * metres


def away(served: Served, document: str, found: dict[str, list[Any]], **asked: Any) -> float:
    """The largest distance of a bone from where it should be, in heights of the body."""
    skeleton = served.get(f"/documents/{document}/skeleton")
    wanted = served.numbers(document, space="positions", **asked)
    wanted = in_blender(wanted, skeleton["likely_up"], skeleton["metres"] or 1.0)
    there = np.array([found[bone["name"]] for bone in skeleton["bones"]]).transpose(1, 0, 2)
    assert there.shape == wanted.shape
    return float(np.abs(there - wanted).max() / np.ptp(wanted[0], axis=0).max())
