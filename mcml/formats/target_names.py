"""Joint names as a format that is narrower than the clip's can hold them."""

from __future__ import annotations

from collections.abc import Collection, Container

from mcml.errors import Notice
from mcml.motion.skeleton import Skeleton


def legal_names(
    skeleton: Skeleton,
    illegal: Container[str],
    illegal_first: str,
    reserved: Collection[str],
    notices: list[Notice],
    title: str,
    *,
    fold_case: bool = False,
    root: str | None = None,
) -> list[str]:
    """Return a name for each joint from its source name; illegal characters become `_`, repeated names get `_2`, `_3` …

    illegal: characters anywhere; illegal_first: at the beginning. reserved: words of the format, in lower case.
    fold_case: names that differ only in case are equal. root: the format's name for a joint without parent. Adds one
    notice if names were changed.
    """
    names: list[str] = []
    used: set[str] = set()
    changed: list[str] = []
    last: dict[str, int] = {}
    for joint in skeleton.joints:
        if root is not None and joint.parent < 0:
            name = root
        else:
            name = "".join("_" if char in illegal else char for char in joint.source_name) or "_"
            if name[0] in illegal_first or name.lower() in reserved:
                name = "_" + name
            base, count = name, last.get(name, 1)
            while (name.lower() if fold_case else name) in used:
                count += 1
                name = f"{base}_{count}"
            last[base] = count
            if name != joint.source_name:
                changed.append(f"{joint.source_name!r} became {name!r}")
        used.add(name.lower() if fold_case else name)
        names.append(name)
    if changed:
        more = f" and {len(changed) - 5} more" if len(changed) > 5 else ""
        notice = Notice("warning", f"names that {title} cannot hold: {', '.join(changed[:5])}{more}")
        if notice not in notices:
            notices.append(notice)
    return names
