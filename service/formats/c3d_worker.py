"""A process of its own that reads C3D: it can be killed, and its memory is bounded.

Run as a program: `python -P c3d_worker.py MEMORY_BYTES MOST_VALUES < FILE > ANSWER` (without -P, `c3d` would be the
module beside it). It imports nothing of the service. The answer begins with a line of JSON, {"error": …} or what the
file says of its points; then for each frame and point x y z and the residual as float32, little-endian, a residual
of -1 where there is no sample; at last a line of JSON {"frames", "warnings"}.
"""

from __future__ import annotations

import json
import resource
import sys
import warnings
from typing import Any

import c3d
import numpy as np


def main() -> None:
    memory, most = int(sys.argv[1]), int(sys.argv[2])
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    target = sys.stdout.buffer
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            reader = c3d.Reader(sys.stdin.buffer)
            about = facts(reader)
        except MemoryError:
            raise
        except Exception as error:  # whatever a damaged file makes the library stumble over
            about = {"error": f"{type(error).__name__}: {error}"}
        if about.get("points", 0) * about.get("declared", 0) * 3 > most:
            about = {"error": f"the file says it has {about['declared']} frames of {about['points']} points"}
        target.write(json.dumps(about).encode() + b"\n")
        if "error" in about:
            return
        frames = 0
        try:
            for _, points, _ in reader.read_frames(copy=False, analog_transform=False):
                target.write(points[:, :4].astype("<f4").tobytes())
                frames += 1
        except MemoryError:
            raise
        except Exception as error:
            warnings.warn(f"{type(error).__name__}: {error}", stacklevel=1)
    said = [" ".join(str(item.message).split()) for item in caught]
    target.write(json.dumps({"frames": frames, "warnings": list(dict.fromkeys(said))}).encode() + b"\n")


def facts(reader: Any) -> dict[str, Any]:
    """What the parameters say of the points; labels from LABELS, LABELS2 … as one list."""
    labels = list(texts(reader, "POINT:LABELS"))
    number = 2
    while more := texts(reader, f"POINT:LABELS{number}"):
        labels += more
        number += 1
    units = texts(reader, "POINT:UNITS")
    screen = texts(reader, "POINT:Y_SCREEN")
    return {
        "points": int(reader.point_used),
        "labels": labels,
        "rate": str(np.float32(reader.point_rate)),
        "scale": float(reader.point_scale),
        "unit": units[0] if units else "",
        "y_screen": screen[0] if screen else "",
        "first": int(reader.first_frame),
        "declared": max(0, int(reader.last_frame) - int(reader.first_frame) + 1),
        "analog": int(reader.analog_used),
        "events": len(texts(reader, "EVENT:LABELS")),
        "processor": str(reader.proc_type),
    }


def texts(reader: Any, name: str) -> list[str]:
    parameter = reader.get(name)
    if parameter is None or not parameter.bytes:
        return []
    if not parameter.dimensions:
        return [parameter.string_value.strip("\0 ")]
    found = np.atleast_1d(parameter.string_array) if len(parameter.dimensions) > 1 else [parameter.string_value]
    return [str(text).strip("\0 ") for text in np.ravel(np.asarray(found, dtype=object))]


if __name__ == "__main__":
    main()
