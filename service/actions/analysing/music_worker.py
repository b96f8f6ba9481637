"""A process of its own that finds the beats of music: decoders of sound are large and read files of strangers.

Its arguments: NAME of the file, which comes on its input, and SECONDS. The answer is one JSON object: {"beats"}, in
seconds, or {"code", "what", "remedy"}.
"""

from __future__ import annotations

import io
import json
import sys

from service.analysis.dance.music import track_beats
from service.analysis.interface import AnalysisError
from service.errors import McmlError
from service.processes.bounds import end_after


def main() -> None:
    end_after(float(sys.argv[2]))
    try:
        answer: dict[str, object] = {"beats": track_beats(io.BytesIO(sys.stdin.buffer.read()), sys.argv[1]).tolist()}
    except McmlError as error:
        code = error.code if isinstance(error, AnalysisError) else type(error).__name__
        answer = {"code": code, "what": error.what, "remedy": error.remedy}
    sys.stdout.write(json.dumps(answer))
