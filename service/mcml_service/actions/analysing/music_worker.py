"""A separate process that finds the beats of music: decoders of sound are large and read untrusted files.

Its arguments: NAME of the file, which is its input, SECONDS, and BPM if stated. The answer is one JSON
object: {"beats", "loudness", "clear", "rivals", "meters"}, times in seconds, or {"code", "what", "remedy"}.
"""

from __future__ import annotations

import io
import json
import sys

from mcml.errors import McmlError
from mcml.processes.bounds import end_after
from mcml_service.analysis.dance.music import track_beats
from mcml_service.analysis.interface import AnalysisError


def main() -> None:
    end_after(float(sys.argv[2]))
    try:
        bpm = float(sys.argv[3]) if len(sys.argv) > 3 else None
        beats = track_beats(io.BytesIO(sys.stdin.buffer.read()), sys.argv[1], bpm)
        answer: dict[str, object] = {
            "beats": beats.beats.tolist(),
            "loudness": [round(level, 6) for level in beats.loudness.tolist()],
            "clear": beats.clear,
            "rivals": [
                {"bpm": rival.bpm, "ratio": str(rival.ratio), "strength": rival.strength} for rival in beats.rivals
            ],
            "meters": [{"beats_per_bar": meter.beats, "strength": meter.strength} for meter in beats.meters],
        }
    except McmlError as error:
        code = error.code if isinstance(error, AnalysisError) else type(error).__name__
        answer = {"code": code, "what": error.what, "remedy": error.remedy}
    sys.stdout.write(json.dumps(answer))
