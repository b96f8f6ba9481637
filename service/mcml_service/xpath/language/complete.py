"""Completions of an expression while it is typed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from mcml.language.content import declarations
from mcml.language.vocabulary import FRAME, MOTION_NAME, NAME
from mcml.motion.bodies.activities.activity import ACTIVITIES
from mcml.motion.bodies.limb_angles import angle_names, clinical_name
from mcml.motion.bodies.quantities import AXES as BODY_AXES
from mcml.motion.bodies.quantities import FEET
from mcml.motion.rigs.roles import known_roles
from mcml_service.xpath.language.functions import FUNCTIONS
from mcml_service.xpath.language.motion_functions import (
    ANGLE,
    JOINT_OR_SIDE,
    JOINTS,
    MOTION_FUNCTIONS,
    NAME_OF_ACTIVITY,
    OF_FRAME_SETS,
)
from mcml_service.xpath.language.reach import DOCUMENT, Types, reach
from mcml_service.xpath.language.rules import after
from mcml_service.xpath.language.tree import AXES, KIND_TESTS, Step

Kind = Literal["element", "attribute", "axis", "function", "motion name", "bone name", "angle", "word"]
MAX_ITEMS = 200

_TOKEN = re.compile(
    r"""'[^']*'|"[^"]*"|[0-9]*\.?[0-9]+|\.\.|::|//|!=|<=|>=|(?:mo:)?[A-Za-z_][\w.-]*|[/@\[\]().,*|+=<>$-]|\s+""",
    re.ASCII,
)
_TYPED = re.compile(r"(?<![\w:.-])mo:[\w.-]*$|[A-Za-z_][\w.-]*$", re.ASCII)
_MORE_FOLLOW = re.compile(r"""[^'"]*['"]\s*,""")
_OPERATORS = frozenset({"=", "!=", "<", "<=", ">", ">=", "+", "-", "|", ",", "or", "and", "div", "mod"})


@dataclass(frozen=True, slots=True)
class Completion:
    """A completion.

    text: replaces the characters from `first` on. kind: its kind. detail: a short description. documents: number of
    documents with this name.
    """

    text: str
    kind: Kind
    detail: str = ""
    documents: int | None = None


@dataclass
class _Level:
    """Inside of a bracket. base: types of the context node. types: where the path that is being read has come to, None
    where none has begun. axis: of the step that comes next. last: the test of the step read last. function: whose
    arguments these are; place: which one this is."""

    base: Types
    types: Types | None = None
    axis: str = "child"
    last: str = ""
    compared: str = ""
    bracket: str = ""
    function: str = ""
    place: int = 0


@dataclass
class _Reader:
    levels: list[_Level] = field(default_factory=lambda: [_Level(frozenset({DOCUMENT}))])

    @property
    def level(self) -> _Level:
        return self.levels[-1]

    def read(self, tokens: list[str]) -> None:
        for place, token in enumerate(tokens):
            before = tokens[place - 1] if place else ""
            self._token(token, before, tokens[place + 1] if place + 1 < len(tokens) else "")

    def _token(self, token: str, before: str, following: str) -> None:
        level = self.level
        if token in ("[", "("):
            inner = level.types if token == "[" and level.types is not None else level.base
            function = before if token == "(" and before in FUNCTIONS else ""
            last = level.last if token == "[" else ""
            self.levels.append(_Level(inner, last=last, bracket=token, function=function))
        elif token in ("]", ")"):
            if len(self.levels) > 1:
                closed = self.levels.pop()
                if token == ")" and closed.function in OF_FRAME_SETS:
                    self.level.types = frozenset({FRAME})
                elif token == ")" and closed.bracket == "(" and closed.types is not None:
                    self.level.types = closed.types
        elif token in ("/", "//"):
            if level.types is None:
                level.types = frozenset({DOCUMENT})
            if token == "//":
                level.types = after(level.types, Step("descendant-or-self", "node()"))
            level.axis = "child"
        elif token == "@":
            level.axis = "attribute"
        elif token == "::":
            pass
        elif token in _OPERATORS and not (token in ("or", "and", "div", "mod") and level.types is None):
            level.compared = level.last if token in ("=", "!=") else ""
            level.types, level.axis = None, "child"
            level.place += token == ","
        elif following == "::":
            level.axis = token
        elif token in (".", ".."):
            self._step(Step("self" if token == "." else "parent", "node()"))
        elif following != "(" and (token == "*" or re.match(r"[A-Za-z_]", token)):
            self._step(Step(level.axis, token))

    def _step(self, step: Step) -> None:
        level = self.level
        level.types = after(level.base if level.types is None else level.types, step)
        if step.name != "node()":
            level.last = step.name
        level.axis = step.axis


def complete(
    text: str, at: int, motion_names: Callable[[], Mapping[str, int]], bone_names: Callable[[], Mapping[str, int]]
) -> tuple[int, list[Completion]]:
    """Return (index of the first character that a completion replaces, completions) at a position in an expression.

    at: characters before the cursor. motion_names, bone_names: return existing names with their number of documents;
    called if a name is compared.
    """
    before = text[:at]
    opened = _open_string(before)
    if opened:
        start = opened
        reader = _Reader()
        reader.read([token for token in _TOKEN.findall(before[: start - 1]) if not token.isspace()])
        more_follow = _MORE_FOLLOW.match(text[at:]) is not None
        return start, list(_named(_strings(reader.level, motion_names, bone_names, more_follow), before[start:]))
    match = _TYPED.search(before)
    start = at if match is None else match.start()
    reader = _Reader()
    reader.read([token for token in _TOKEN.findall(before[:start]) if not token.isspace()])
    return start, list(_named(_steps(reader.level), before[start:]))


def _named(found: Iterable[Completion], typed: str) -> Iterator[Completion]:
    """Yield completions that begin with the typed text, then, from two letters on, those that contain it."""
    items = list(dict.fromkeys(found))
    lower = typed.lower()
    begin = [item for item in items if item.text.lower().startswith(lower)]
    hold = [item for item in items if len(lower) > 1 and lower in item.text.lower() and item not in begin]
    yield from [*begin, *hold][:MAX_ITEMS]


def _open_string(text: str) -> int:
    """Where the string begins that the cursor is in, 0 for none."""
    quote, start = "", 0
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote, start = letter, place + 1
    return start if quote else 0


def _strings(
    level: _Level,
    motion_names: Callable[[], Mapping[str, int]],
    bone_names: Callable[[], Mapping[str, int]],
    more_follow: bool,
) -> Iterator[Completion]:
    if level.compared == MOTION_NAME:
        yield from (Completion(text, "motion name", documents=count) for text, count in motion_names().items())
    elif level.compared == NAME:
        yield from (Completion(text, "bone name", documents=count) for text, count in bone_names().items())
    elif level.compared == "role":
        yield from (Completion(text, "word", "of joints without an MCML name") for text in known_roles())
    elif level.function in MOTION_FUNCTIONS and level.types is None:
        yield from _of_motion(level, bone_names, more_follow)


def _of_motion(level: _Level, bone_names: Callable[[], Mapping[str, int]], more_follow: bool) -> Iterator[Completion]:
    """Yield possible values of an argument of a function of bodies in motion.

    more_follow: whether further arguments follow.
    """
    parameters = MOTION_FUNCTIONS[level.function].parameters
    parameter = parameters[level.place].rstrip("?") if level.place < len(parameters) else ""
    if level.function == ANGLE and not level.place and not more_follow:
        for name in angle_names():
            clinical = clinical_name(name)
            yield Completion(name, "angle", "" if clinical is None else f"goniometer; clinical: {clinical}")
    if parameter == JOINT_OR_SIDE:
        yield from (Completion(side, "word", "the foot, from strike to off") for side in FEET)
    if parameter == NAME_OF_ACTIVITY:
        yield from (Completion(name, "word", "an activity") for name in ACTIVITIES)
    if parameter in JOINTS:
        yield from (Completion(text, "bone name", documents=count) for text, count in bone_names().items())
    elif parameter == "axis":
        yield from (Completion(axis, "word", "of the world" if len(axis) == 1 else "of the body") for axis in BODY_AXES)
    elif parameter == "'frames'":
        yield Completion("frames", "word", "a window of frames, not of seconds")


def _steps(level: _Level) -> Iterator[Completion]:
    types = level.base if level.types is None else level.types
    reached = frozenset[str]().union(*(reach(source, Step(level.axis, "*")) for source in types))
    if level.axis == "attribute":
        for owner in sorted(found.removeprefix("@") for found in reached):
            yield from (
                Completion(name, "attribute", f"of {owner}") for name in sorted(declarations()[owner].attributes)
            )
        return
    yield from (Completion(name, "element") for name in sorted(reached))
    if level.types is None:
        plain = (name for name in sorted(FUNCTIONS) if name not in MOTION_FUNCTIONS)
        yield from (Completion(f"{name}(", "function") for name in plain)
    if level.types is None or FRAME in level.types:
        yield from (Completion(f"{name}(", "function", one.detail) for name, one in MOTION_FUNCTIONS.items())
    yield from (Completion(f"{axis}::", "axis") for axis in AXES)
    yield from (Completion(f"{test}()", "function", "node test") for test in KIND_TESTS)
