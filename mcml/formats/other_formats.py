"""Formats that people send and that are not read: how to tell them, and what to do."""

from __future__ import annotations

import re
from typing import Final

from mcml.errors import Place, UnsupportedError
from mcml.patterns import end_of_matches

TO_BVH: Final = "Convert it to BVH, for example in Blender: import it, then File > Export > Motion Capture (.bvh)."
_UNPACK: Final = "Unpack it, and send the files or a zip of them."
_THE_FILE: Final = "Send the motion file itself."

_BY_BEGINNING: Final = (
    (rb"Vocaloid (Motion|Pose) Data", "VMD and VPD (MikuMikuDance)", f"{TO_BVH} The add-on MMD Tools reads it."),
    (rb"PM[XD] |Pmd\0\0\x80\x3f", "PMX and PMD (MikuMikuDance)", "Models hold no motion: send the motion as BVH."),
    (rb"Rar!\x1a\x07", "RAR", _UNPACK),
    (rb"\xfd7zXZ\0", "xz", _UNPACK),
    (rb"BZh[1-9]1AY&SY", "bzip2", _UNPACK),
    (rb"\x28\xb5\x2f\xfd", "Zstandard", _UNPACK),
    (rb"MSCF\0", "cabinet", _UNPACK),
    (rb"BLENDER", "Blender", "Export the motion there: File > Export > Motion Capture (.bvh)."),
    (rb"//Maya ASCII|FOR[4-8].{4,20}Maya", "Maya", "Export the motion as FBX, and convert that to BVH in Blender."),
    (rb"Ogawa", "Alembic", "Alembic holds meshes: export the skeleton as BVH."),
    (rb"\x89HDF\r\n", "HDF5", "Write the motion as BVH, TRC, C3D or MCML."),
    (rb"\x93NUMPY", "NumPy", "Write the motion as BVH, TRC, C3D or MCML."),
    (rb"%PDF-", "PDF", _THE_FILE),
    (rb"\x89PNG|\xff\xd8\xff|GIF8", "image", _THE_FILE),
    (rb".{4}ftyp|RIFF.{4}(AVI |WAVE)|\x1aE\xdf\xa3|ID3[\0-\x04]", "film and sound", _THE_FILE),
    (rb"\xd0\xcf\x11\xe0", "3ds Max and Office", "Export the motion as BVH."),
    (rb"\s*[\[{]\s*[\"\[{\]}]", "JSON", "Write the motion as BVH, TRC, C3D or MCML."),
)
"""First bytes of files, with the name of their format and a remedy."""

_BY_ROOT: Final = (
    (rb"collada", "COLLADA", TO_BVH),
    (rb"html|!doctype\s+html|head|body", "web page (HTML)", "Download the file itself, not the page that shows it."),
    (rb"svg", "image", _THE_FILE),
    (rb"x3d|scene", "X3D", TO_BVH),
    (rb"opensimdocument", "OpenSim model", "Send the markers as TRC or C3D."),
    (rb"rss|feed|plist|kml|gpx|error|listbucketresult", "other XML", _THE_FILE),
)
"""Roots of XML that is no MCML, likewise."""

_BEFORE_ROOT: Final = re.compile(rb"\s+|<\?.*?\?>|<!--.*?-->|<!doctype\s+(?!\s|html)[^>]*>", re.DOTALL | re.IGNORECASE)


def other_format(first_bytes: bytes) -> tuple[str, str] | None:
    """(what the format is called, what to do) of a file that is not read; None for one that nothing is known of."""
    for pattern, title, remedy in _BY_BEGINNING:
        if re.match(pattern, first_bytes, re.DOTALL):
            return title, remedy
    return None


def root_of(first_bytes: bytes) -> bytes | None:
    """The name of the root element of XML in UTF-8, without its prefix; None for anything else."""
    text = first_bytes.removeprefix(b"\xef\xbb\xbf")
    root = re.compile(rb"<(?:[\w.-]+:)?([\w.-]+)[\s/>]").match(text, end_of_matches(_BEFORE_ROOT, text))
    return root[1] if root else None


def refuse_other_xml(file_name: str, first_bytes: bytes) -> None:
    """Raises UnsupportedError for XML that is no MCML, by its root element. first_bytes: in UTF-8."""
    start = end_of_matches(_BEFORE_ROOT, first_bytes)
    for pattern, title, remedy in _BY_ROOT:
        root = re.compile(rb"<(?:[\w.-]+:)?(?:%b)[\s/>]" % pattern, re.IGNORECASE)
        if root.match(first_bytes, start):
            raise UnsupportedError(f"{title} files are not read", at=Place(file=file_name), remedy=remedy)
