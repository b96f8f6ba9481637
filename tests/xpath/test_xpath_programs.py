"""Evaluating programs end by themselves where the one who asked is gone."""

from __future__ import annotations

import json
import signal
import subprocess
from typing import Any

import pytest

from mcml_service.processes.bounds import GRACE_SECONDS
from mcml_service.processes.messages import write_message
from mcml_service.processes.programs import end_program, start_program
from mcml_service.xpath.xml.evaluate import Evaluator
from mcml_service.xpath.xml.saxon import Saxon

MANY = b"<mcml>" + b"<frame/>" * 3000 + b"</mcml>"
ENDLESS = "count(//*[count(//*[count(//*[count(//*) = 1]) = 1]) = 1])"


@pytest.mark.parametrize(
    ("pool", "asked"),
    [(Evaluator, {"expression": ENDLESS, "document": False}),
     (Saxon, {"expression": "count(for $i in 1 to 100000000, $j in 1 to 100000000 return $i)", "variables": {}})],
)  # fmt: skip
def test_a_program_ends_with_the_time_of_its_request(pool: type[Evaluator], asked: dict[str, Any]) -> None:
    pipe = subprocess.PIPE
    process = start_program(pool.program, str(1 << 30), stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
    try:
        assert process.stdin is not None
        request = {"seconds": 0.5 - GRACE_SECONDS, "limit": 1, "offset": 0, **asked}
        for message in (json.dumps(request).encode(), MANY, b""):
            write_message(process.stdin, message)
        assert process.wait(timeout=60) == -signal.SIGALRM
    finally:
        end_program(process)
