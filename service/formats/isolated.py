"""Readers of other makers in processes of their own, with a limit of time and of memory.

What reads binary files of strangers may crash, hang or take all memory; here that ends a process and becomes an error.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from service.errors import FormatError, LimitError
from service.formats.format import Limits


def run(program: Path, arguments: Sequence[str], stream: BinaryIO, limits: Limits) -> BinaryIO:
    """What a Python program writes when it gets a file as its input, as a file that is gone once it is closed.

    Raises LimitError where it takes too long, FormatError where it ends badly.
    """
    with tempfile.TemporaryFile() as source:
        stream.seek(0)
        shutil.copyfileobj(stream, source, 1 << 20)
        source.seek(0)
        target = tempfile.TemporaryFile()  # noqa: SIM115  # the caller closes it
        try:
            done = subprocess.run(
                [sys.executable, "-P", str(program), *arguments],
                stdin=source,
                stdout=target,
                stderr=subprocess.PIPE,
                timeout=limits.seconds,
                check=False,
            )
        except subprocess.TimeoutExpired:
            target.close()
            raise LimitError(
                f"reading the file took longer than {limits.seconds:g} seconds", remedy="Cut it into parts."
            ) from None
        except BaseException:
            target.close()
            raise
    if done.returncode:
        target.close()
        if b"MemoryError" in done.stderr:
            raise LimitError(
                f"reading the file took more than {limits.memory >> 20} MiB of memory", remedy="Cut it into parts."
            )
        raise FormatError("the file is damaged: its reader crashed", remedy="Save it again with another program.")
    target.seek(0)
    return target
