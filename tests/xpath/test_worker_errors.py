"""Errors in the processes that evaluate queries: of memory, and of libraries."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator

import pytest
from lxml import etree

from mcml_service.xpath.query_worker import _portable
from mcml_service.xpath.trees.evaluate import _read


def document(frames: int) -> Iterator[bytes]:
    yield b"<mcml>"
    for number in range(frames):
        yield b"<frame id='%d'><frame_bone name='left_hand' Rx='1.5'/></frame>" % number
    yield b"</mcml>"


# A fresh process: in a copy of this one, memory that other tests gave back would do.
PROGRAM = """
import re, resource, sys
from pathlib import Path
from mcml_service.xpath.trees.evaluate import _read
from tests.xpath.test_worker_errors import document
now = int(re.findall(r"VmData:\\s+(\\d+)", Path("/proc/self/status").read_text())[0]) << 10
resource.setrlimit(resource.RLIMIT_DATA, (now + (int(sys.argv[1]) << 20),) * 2)
try:
    _read(document(2_000_000), 0)
except MemoryError:
    print("no memory")
"""


@pytest.mark.parametrize("mebibytes", [2, 8, 16])
def test_a_tree_without_memory_is_an_error_of_memory(mebibytes: int) -> None:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    asked = [sys.executable, "-c", PROGRAM, str(mebibytes)]
    done = subprocess.run(asked, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "no memory\n"


def test_errors_of_libraries_can_be_sent() -> None:
    with pytest.raises(etree.XMLSyntaxError) as raised:
        _read(iter([b"<mcml>"]), 0)
    with pytest.raises(TypeError):
        pickle.dumps(raised.value)
    sent = pickle.loads(pickle.dumps(_portable(raised.value)))
    assert str(sent).startswith("XMLSyntaxError: ")
    assert "in _read" in sent.__notes__[0]
