"""The fixed questions of the XPath benchmark: what each engine is asked, and what is wanted of us."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

BONES = (
    "left_up_arm", "right_up_arm", "left_low_arm", "right_low_arm", "left_up_leg", "right_up_leg", "left_low_leg",
    "right_low_leg", "left_foot", "right_foot", "left_hand", "right_hand", "neck1", "Head", "Root",
)  # fmt: skip
"""Bones that nearly all clips have."""

CHANNELS = ("Rx", "Ry", "Rz")

WANTED = {"predicate": 50.0, "label": 5.0, "position": 3.0, "xml": 1.5, "array": 10.0, "aggregate": 20.0, "lookup": 0.0}
"""How many times faster than BaseX each kind of question shall be; a lookup shall only not be slower by over 1 ms."""

WANTED_AFTER_EDIT = 100.0
"""The same for the labels, after one edit of one document on both sides."""

Kind = Literal["predicate", "label", "position", "xml", "array", "aggregate", "lookup"]
Form = Literal["xml", "json", "runs", "array"]
Join = Literal["nodes", "sum", "average", "most", "distinct", "ids"]


@dataclass(frozen=True)
class Question:
    """ask: in XPath, constants in braces. form: as what we are asked. scope: all documents, one (the same in each
    library), or another one each time. basex: its spelling where it is another one; plain: the part that XPath 1.0
    can say of one document; join: how the answers of that part make the whole. times: how often it is asked at most."""

    name: str
    kind: Kind
    ask: str
    form: Form = "json"
    scope: Literal["all", "one", "each"] = "all"
    basex: str = ""
    plain: str = ""
    join: Join = "nodes"
    same_size: bool = False
    times: int = 15

    def asked(self, constants: dict[str, str]) -> str:
        return self.ask.format_map(constants)

    def asked_of_basex(self, constants: dict[str, str], document: str | None) -> str:
        expression = (self.basex or self.ask).format_map(constants)
        return expression if document is None else f"doc('{document}'){expression}"

    def asked_of_one(self, constants: dict[str, str]) -> str:
        return (self.plain or self.ask).format_map(constants)


def constants(number: int, pairs: list[tuple[str, str]]) -> dict[str, str]:
    """What stands in the braces. Another number gives a question another text, up to 45 of them; ten where only
    a digit is asked for. Two questions have no constants.

    pairs: motion names that overlap somewhere.
    """
    first, second = pairs[number % len(pairs)]
    return {
        "k": str(number),
        "label": f"move-{number}",
        "only": f"only-{number}",
        "first": first,
        "second": second,
        "bone": BONES[number % len(BONES)],
        "channel": CHANNELS[number // len(BONES) % len(CHANNELS)],
        "id": str(100 + number),
        "from": str(101 + number),
        "to": str(300 + number),
        "digit": str(number % 10),
    }


# Sums of two channels are compared with numbers off the grid of the data: libxml2 reads some numbers an ulp wrong, and
# would decide differently where two sides are equal.
QUESTIONS = (
    Question("label: count of frames", "label", "count(//frame[motion_name='{label}'])", join="sum"),
    Question("label: runs of frames", "label", "//frame[motion_name='{label}']", "runs", join="ids",
             basex="//frame[motion_name='{label}']/string(@id)", plain="//frame[motion_name='{label}']/@id"),
    Question("label: whole frames", "xml", "//frame[motion_name='{label}']", "xml"),
    Question("label of one document: count", "label", "count(//frame[motion_name='{only}'])", join="sum",
             same_size=True),
    Question("label of one document: whole frames", "xml", "//frame[motion_name='{only}']", "xml", same_size=True),
    Question("two labels within one frame: count", "label",
             "count(//frame[motion_name='{first}'][motion_name='{second}'])", join="sum"),
    Question("distinct motion names", "lookup", "distinct-values(//motion_name[. != '{label}'])",
             plain="//motion_name[. != '{label}']/text()", join="distinct"),
    Question("frame by id", "lookup", "//frame[@id='{id}']", "xml"),
    Question("frame by id, one document", "lookup", "//frame[@id='{id}']", "xml", "one", same_size=True),
    Question("bone and threshold: count", "predicate", "count(//frame_bone[@name='left_up_arm'][@Rx > {k}.5])",
             join="sum"),
    Question("bone and threshold: few nodes", "predicate",
             "//frame_bone[@name='left_up_arm'][@Rx > 10{digit}.{k}]", "xml"),
    Question("bone and threshold: many nodes", "xml", "//frame_bone[@name='left_up_arm'][@Rx > 3{digit}.{k}]", "xml"),
    Question("threshold, all bones: count", "predicate", "count(//frame_bone[@Rx > 17{digit}.{k}5])", join="sum"),
    Question("threshold, all bones: one node", "predicate", "//frame_bone[@Rz > 9{k}000]", "xml", same_size=True),
    Question("frames by a bone's threshold: count", "predicate",
             "count(//frame[frame_bone[@name='left_up_arm']/@Rx > {k}.25])", join="sum"),
    Question("one joint's rotation above another's: count", "predicate",
             "count(//frame[frame_bone[@name='left_up_arm']/@Rx"
             " > frame_bone[@name='right_up_arm']/@Rx + {k}.000000317])",
             join="sum"),
    Question("channel against channel: count", "predicate",
             "count(//frame_bone[@name='{bone}'][@Rx > @Ry + {k}.000000317])", join="sum"),
    Question("bones below a bone", "lookup", "//bone[name='{bone}']/descendant::bone/name", "xml"),
    Question("every tenth frame of a document", "position", "//frame[position() mod 10 = {digit}]", "xml", "one",
             same_size=True, times=7),
    Question("200 frames of a document", "position", "//frame[position() >= {from} and position() <= {to}]", "xml",
             "one", same_size=True),
    Question("frame by position, one document", "position", "/mcml/motion/frame[{to}]", "xml", "one", same_size=True),
    Question("a whole document", "xml", "/mcml", "xml", "each"),
    Question("all frames of a document", "xml", "//frame[position() > {k}]", "xml", "one", same_size=True),
    Question("all frames of a document as array", "array", "//frame[position() > {k}]", "array", "one",
             same_size=True),
    Question("sum", "aggregate", "sum(//frame_bone[@name='{bone}']/@{channel})", join="sum"),
    Question("average", "aggregate", "avg(//frame_bone[@name='{bone}']/@{channel})",
             plain="//frame_bone[@name='{bone}']/@{channel}", join="average"),
    Question("maximum", "aggregate", "max(//frame_bone[@name='{bone}']/@{channel})",
             plain="//frame_bone[@name='{bone}']/@{channel}", join="most"),
    Question("maximum below a value", "aggregate", "max(//frame_bone[@name='left_up_arm']/@Rx[. < 9{digit}.{k}])",
             plain="//frame_bone[@name='left_up_arm']/@Rx[. < 9{digit}.{k}]", join="most"),
    Question("count of all samples", "aggregate", "count(//frame_bone)", join="sum"),
)  # fmt: skip
