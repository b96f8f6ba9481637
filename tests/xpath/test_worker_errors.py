"""Errors in the processes that evaluate queries: of memory, and of libraries."""

from __future__ import annotations

import os
import pickle
import re
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import etree

from mcml_service.xpath.query_worker import _portable
from mcml_service.xpath.trees.evaluate import _read


def document(frames: int) -> Iterator[bytes]:
    yield b"<mcml>"
    for number in range(frames):
        yield b"<frame id='%d'><frame_bone name='left_hand' Rx='1.5'/></frame>" % number
    yield b"</mcml>"


@pytest.mark.parametrize("mebibytes", [2, 8, 16])
def test_a_tree_without_memory_is_an_error_of_memory(mebibytes: int) -> None:
    """In a process of its own, whose memory is limited."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            said = Path("/proc/self/status").read_text()
            now = int(re.findall(r"VmData:\s+(\d+)", said)[0]) << 10
            resource.setrlimit(resource.RLIMIT_DATA, (now + (mebibytes << 20),) * 2)
            _read(document(2_000_000), 0)
        except BaseException as error:
            os.write(writing, type(error).__name__.encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.close(writing)
    with open(reading, "rb") as told:
        assert told.read() == b"MemoryError"


def test_errors_of_libraries_can_be_sent() -> None:
    with pytest.raises(etree.XMLSyntaxError) as raised:
        _read(iter([b"<mcml>"]), 0)
    with pytest.raises(TypeError):
        pickle.dumps(raised.value)
    sent = pickle.loads(pickle.dumps(_portable(raised.value)))
    assert str(sent).startswith("XMLSyntaxError: ")
    assert "in _read" in sent.__notes__[0]
