"""Repairs of AMC whose bones have three values each, as programs write with :FORCE-ALL-JOINTS-BE-3DOF.

An ASF that gives a bone fewer degrees of freedom can be meant in two ways: the values of the axes that it names count
(`stated-dof`), or the bone turns about all three (`three-dof`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

_BONE = re.compile(rb"\bbegin\b(.*?)\bend\b", re.IGNORECASE | re.DOTALL)
_NAME = re.compile(rb"^[ \t]*name[ \t]+(\S+)", re.IGNORECASE | re.MULTILINE)
_DOF = re.compile(rb"^([ \t]*)dof\b([^\r\n#]*)", re.IGNORECASE | re.MULTILINE)
_ROW = re.compile(rb"^([ \t]*)([^\s#:]+)([ \t]+[^\r\n#]*)", re.MULTILINE)
_AXES = (b"rx", b"ry", b"rz")


def stated_dof(files: Mapping[str, bytes]) -> tuple[dict[str, bytes], str]:
    """Keep only values with a degree of freedom in the ASF; return the files and a description."""
    wanted, count = _fewer(files), 0

    def kept(row: re.Match[bytes]) -> bytes:
        nonlocal count
        dof, values = wanted.get(row[2].lower()), row[3].split()
        if dof is None or len(values) != 3:
            return row[0]
        count += 1
        chosen = [values[_AXES.index(axis)] for axis in dof]
        return row[1] + b" ".join([row[2], *chosen])

    if not wanted:
        return dict(files), ""
    amc = _ROW.sub(kept, files["amc"])
    names = _listed(wanted)
    words = f"of three values each, {count} rows keep those of the ASF's dof ({names})" if count else ""
    return {**files, "amc": amc}, words


def three_dof(files: Mapping[str, bytes]) -> tuple[dict[str, bytes], str]:
    """Give bones with three values three degrees of freedom in the ASF; return the files and a description."""
    wanted = _fewer(files)
    if not wanted:
        return dict(files), ""

    def widened(bone: re.Match[bytes]) -> bytes:
        name = _NAME.search(bone[1])
        if name is None or name[1].lower() not in wanted:
            return bone[0]
        if _DOF.search(bone[1]):
            return bone[0].replace(bone[1], _DOF.sub(rb"\1dof rx ry rz", bone[1], count=1))
        return bone[0].replace(bone[1], bone[1].rstrip() + b"\n    dof rx ry rz\n  ")

    asf = _BONE.sub(widened, files["asf"])
    return {**files, "asf": asf}, f"bones of three values turn about all three axes ({_listed(wanted)})"


def _fewer(files: Mapping[str, bytes]) -> dict[bytes, tuple[bytes, ...]]:
    """The axes that the ASF lets bones turn about, of those with three values and fewer axes; by their small names."""
    if not {"asf", "amc"} <= files.keys():
        return {}
    dofs: dict[bytes, tuple[bytes, ...]] = {}
    for bone in _BONE.finditer(files["asf"]):
        name, dof = _NAME.search(bone[1]), _DOF.search(bone[1])
        axes = tuple(dof[2].lower().split()) if dof is not None else ()
        if name is not None and len(axes) < 3 and set(axes) <= set(_AXES):
            dofs[name[1].lower()] = axes
    found = {row[2].lower() for row in _ROW.finditer(files["amc"]) if len(row[3].split()) == 3}
    return {name: axes for name, axes in dofs.items() if name in found}


def _listed(names: Mapping[bytes, tuple[bytes, ...]]) -> str:
    shown = [name.decode("latin-1") for name in names][:5]
    return ", ".join(shown) + (" …" if len(names) > len(shown) else "")
