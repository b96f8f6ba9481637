"""The questions of the benchmark of large libraries, by what their answer costs. `{k}`: another number each time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Class:
    """Questions of one kind. wanted: ms, warm, of 3,076 and of 30,760 clips."""

    name: str
    wanted: tuple[float, float]
    questions: tuple[str, ...]


_LEG = "frame_bone[@name='left_up_leg']"
_OTHER = "frame_bone[@name='right_up_leg']"

CLASSES = (
    Class(
        "heads, counts, ids, names, statistics",
        (6, 10),
        (
            "count(//frame)",
            "count(//frame_bone)",
            "count(//header)",
            "count(//bone)",
            "count(//bone[name='left_up_leg'])",
            "count(/mcml[contains(header/filename,'walk_{k}')])",
            "count(//frame[@id='{k}'])",
            "distinct-values(//motion_name)",
            "count(distinct-values(//bone/name))",
            "max(//frame_bone[@name='left_up_leg']/@Rx)",
            "avg(//frame_bone[@name='left_up_leg']/@Ry)",
            "sum(//frame_bone[@name='left_up_leg']/@Rz)",
            "//frame[frame_bone[@name='Root']/@Ty > 1000{k}]",
            "count(//frame[frame_bone/@Rx > 1000{k}])",
        ),
    ),
    Class(
        "first 100 hits of a predicate on channels",
        (12, 20),
        (
            f"//{_LEG}[@Rx > {{k}}]",
            f"//{_LEG}[@Rx > {{k}}]/@Ry",
            f"//frame[{_LEG}/@Rx > {_OTHER}/@Rx + {{k}}]/@id",
            "//frame_bone[@Rx > {k}]",
        ),
    ),
    Class("100 frames of 100 documents", (60, 40), ("//frame[1{k}]",)),
    Class(
        "one column over the library",
        (15, 40),
        (f"count(//{_LEG}[@Rx > {{k}}])", f"count(//frame[{_LEG}/@Rz < {{k}}])", f"avg(//{_LEG}[@Rx > {{k}}]/@Rx)"),
    ),
    Class(
        "two columns compared",
        (20, 40),
        (f"count(//frame[{_LEG}/@Rx > {_OTHER}/@Rx + {{k}}])",),
    ),
    Class("all bones", (80, 40), ("count(//frame_bone[@Rx > {k}])",)),
    Class(
        "XPath 2.0",
        (50, 40),
        (
            "for $m in /mcml return count($m//frame) + {k}",
            "max(for $m in /mcml return count($m//frame) + {k})",
            "for $n in distinct-values(//bone/name) return concat($n, ' {k} ', count(//frame_bone[@name=$n]))",
            "string-join(distinct-values(//bone/name), '{k}')",
            "count(//frame) div count(/mcml) + {k}",
            "some $f in //frame satisfies $f/frame_bone[@name='left_up_leg']/@Rx > 1000{k}",
            "every $m in /mcml satisfies count($m//frame) > {k}",
            "if (count(//frame[@id='{k}']) > 5) then 'many' else 'few'",
            "count(//frame[@id = {k} to 90])",
            "count(//frame[@id = ('{k}', '5')])",
            "count(//filename[matches(., 'walk.*{k}')])",
            "distinct-values(//filename ! replace(., '_.*', '{k}'))",
            "distinct-values(for $f in //filename return tokenize($f, '_')[2] || '{k}')",
            "count(//frame except //frame[@id='{k}'])",
            "sort(/mcml, (), function($m) { count($m//frame) })[{k}]/header/filename",
            "avg(//frame/count(frame_bone)) + {k}",
            "count(for $m in /mcml return $m//frame[{k}])",
            "math:sqrt(count(//frame)) + {k}",
        ),
    ),
)
