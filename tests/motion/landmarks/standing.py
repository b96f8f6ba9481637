"""A standing body of markers of Plug-in Gait, without the right arm."""

from __future__ import annotations

import numpy as np

from mcml.motion.markers import marker_skeleton

STANDING = {
    "LASI": (120, 130, 1000), "RASI": (120, -130, 1000), "LPSI": (-60, 45, 1010), "RPSI": (-60, -45, 1010),
    "LTHI": (0, 190, 750), "RTHI": (0, -190, 720), "LKNE": (0, 150, 520), "RKNE": (0, -150, 520),
    "LTIB": (-10, 180, 300), "RTIB": (-10, -180, 280), "LANK": (-20, 140, 90), "RANK": (-20, -140, 90),
    "LHEE": (-80, 100, 40), "RHEE": (-80, -100, 40), "LTOE": (120, 110, 40), "RTOE": (120, -110, 40),
    "LSHO": (0, 200, 1450), "RSHO": (0, -200, 1450), "C7": (-80, 0, 1480), "CLAV": (60, 0, 1420),
    "LFHD": (60, 70, 1640), "RFHD": (60, -70, 1640), "LBHD": (-90, 60, 1620), "RBHD": (-90, -60, 1620),
    "LELB": (-20, 280, 1150), "LWRA": (60, 280, 900), "LWRB": (0, 310, 900),
}  # fmt: skip
"""Millimetres of the markers of a body that looks along x, y to its left."""
NAMES = list(STANDING)
SKELETON = marker_skeleton(NAMES)
PLACES = np.array([list(STANDING.values())], dtype=float)
