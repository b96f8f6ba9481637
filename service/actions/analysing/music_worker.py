"""A process of its own that finds the beats of music: decoders of sound are large and read files of strangers.

Run as a program: `python -P music_worker.py NAME < FILE > ANSWER`. The answer is one JSON object: {"beats"}, seconds,
or {"code", "what", "remedy"}.
"""

from __future__ import annotations

import io
import json
import sys

from service.analysis.dance.music import track_beats
from service.analysis.interface import AnalysisError
from service.errors import McmlError


def main() -> None:
    try:
        answer: dict[str, object] = {"beats": track_beats(io.BytesIO(sys.stdin.buffer.read()), sys.argv[1]).tolist()}
    except McmlError as error:
        code = error.code if isinstance(error, AnalysisError) else type(error).__name__
        answer = {"code": code, "what": error.what, "remedy": error.remedy}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    main()
