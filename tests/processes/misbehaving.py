"""A program that does what its first argument says."""

from __future__ import annotations

import os
import resource
import signal
import sys

from mcml.processes.bounds import end_after


def main() -> None:
    behaviour = sys.argv[1]
    if behaviour == "echo":
        sys.stdout.buffer.write(sys.stdin.buffer.read() + " ".join(sys.argv[2:]).encode())
    elif behaviour == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif behaviour == "grow":
        grow()
    elif behaviour == "grow-bounded":
        resource.setrlimit(resource.RLIMIT_AS, (1 << 28, 1 << 28))
        grow()
    else:
        if behaviour == "hang-bounded":
            end_after(-4.5)
        # Nothing of Python runs while this raises a power: no signal handler, and no other thread.
        print(3 ** (10**9))


def grow() -> None:
    held = []
    while True:
        held.append(bytearray(b"x" * (1 << 20)))
