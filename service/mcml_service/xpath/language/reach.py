"""How much of a document an expression can see.

Frames and frame_bones are nearly all of a document. An expression that cannot reach them gives the same answer on a
document without them, so they are never read from the store, written as XML or parsed. The decision follows the
element types that each step can reach, by the content models of the DTD; where in doubt, more is kept.
Node types are written as the tag of an element, `@tag` for its attributes, `#tag` for its text, `/` for the document.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache, lru_cache

from mcml.language.content import declarations
from mcml.language.vocabulary import FRAME, FRAME_BONE, HEADER, MCML, MOTION, MOTION_NAME, ROOT, SKELETON
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, WINDOW
from mcml_service.xpath.language.tree import (
    OF_NODES,
    Binder,
    Call,
    Each,
    Expression,
    Filter,
    Function,
    If,
    Later,
    Literal,
    Operation,
    Path,
    Quantified,
    Sequence,
    Step,
    Variable,
    Written,
)

DOCUMENT = "/"
Types = frozenset[str]


class Projection(IntEnum):
    """The parts that an expression needs: no frames, frames without their frame_bones, or everything."""

    HEAD = 0
    FRAMES = 1
    WHOLE = 2


class HeadPart(IntEnum):
    """Of the head of a document: `mcml` and the motion without frames, the header too, or all."""

    MOTION = 0
    HEADER = 1
    ALL = 2


_FRAME_TYPES = frozenset({FRAME, f"@{FRAME}", MOTION_NAME, f"#{MOTION_NAME}"})
_BONE_TYPES = frozenset({FRAME_BONE, f"@{FRAME_BONE}"})
_STRUCTURE = _FRAME_TYPES | _BONE_TYPES | {DOCUMENT, MCML, f"@{MCML}", MOTION}
_STRUCTURE |= {f"{mark}{name}" for name in ("frames", "frametime") for mark in ("", "#")}
"""Types of nodes that every document has, and of nodes in frames."""
_WITH_FRAMES = frozenset({DOCUMENT, MCML, MOTION, FRAME})
"""Types whose elements hold frames or frame_bones: serialised, they need them."""


def projection(tree: Expression) -> Projection:
    """The least projection on which the expression has its value, nodes serialised."""
    analysis = Analysis()
    return analysis.projection(analysis.types(tree, frozenset({DOCUMENT})))


def head_of(tree: Expression, *, counted: bool = False) -> HeadPart:
    """Return the part of the head that the value depends on or contains.

    counted: only the number of nodes is needed.
    """
    analysis = Analysis()
    result = analysis.types(tree, frozenset({DOCUMENT}))
    analysis.use(result)
    # Functions that take the nodes, such as sum(), may read their text, which includes the header's.
    if result & {DOCUMENT, MCML} and not counted:
        return HeadPart.ALL
    if analysis.sees_only(_STRUCTURE):
        return HeadPart.MOTION
    header = _inside(HEADER)
    return HeadPart.HEADER if analysis.sees_only(_STRUCTURE | header) else HeadPart.ALL


def is_of_skeleton(tree: Expression) -> bool:
    """Whether the value depends on skeletons alone, and is no node but of them."""
    analysis = Analysis()
    result = analysis.types(tree, frozenset({DOCUMENT}))
    analysis.use(result)
    if result & {DOCUMENT, MCML}:
        return False
    return analysis.sees_only(_inside(SKELETON) | _inside(ROOT) | {DOCUMENT, MCML})


def types_of(tree: Expression, context: Types = frozenset({DOCUMENT})) -> Types:
    """Types of the nodes that an expression can select; of a value, none."""
    return Analysis().types(tree, context)


class Analysis:
    """Collects the types of all nodes that an expression can depend on."""

    def __init__(self) -> None:
        self._used: set[str] = set()
        self._bound: dict[str, Types] = {}
        self._head_text = False

    def use(self, types: Types) -> None:
        self._used |= types

    def projection(self, result: Types) -> Projection:
        """The least projection for all that has been seen. result: types of the nodes of the value."""
        self.use(result)
        if self._used & _BONE_TYPES or result & _WITH_FRAMES:
            return Projection.WHOLE
        return Projection.FRAMES if self._used & _FRAME_TYPES else Projection.HEAD

    def sees_only(self, types: Types) -> bool:
        return not self._head_text and self._used <= types

    def types(self, expression: Expression, context: Types) -> Types:
        """Types of the nodes selected; of a value, none. context: types of the context node."""
        if isinstance(expression, Literal):
            return frozenset()
        if isinstance(expression, Written):
            self.use(EVERYTHING)
            self._head_text = True
            return EVERYTHING
        if isinstance(expression, Path):
            return self._path(expression, context)
        if isinstance(expression, Filter):
            found = self.types(expression.operand, context)
            self.use(found)
            self._predicates(expression.predicates, found)
            return found
        if isinstance(expression, Operation):
            operands = [self.types(operand, context) for operand in expression.operands]
            if expression.operator in OF_NODES:
                self.use(frozenset().union(*operands[1:]))
                return frozenset().union(*operands)
            for operand in operands:
                self.value(operand)
            return frozenset()
        if isinstance(expression, Call):
            return self._call(expression, context)
        return self._later(expression, context)

    def _later(self, expression: Later, context: Types) -> Types:
        if isinstance(expression, Variable):
            return expression.reached | self._bound.get(expression.name, frozenset())
        if isinstance(expression, Sequence):
            return frozenset[str]().union(*(self.types(item, context) for item in expression.items))
        if isinstance(expression, If):
            self.use(self.types(expression.test, context))
            return self.types(expression.then, context) | self.types(expression.otherwise, context)
        if isinstance(expression, Function):
            self.value(self.types(expression.body, context))
            return frozenset()
        found = self.types(expression.source, context)
        self.use(found)
        if isinstance(expression, Binder):
            # For variables with the same name, the union of their types.
            self._bound[expression.variable] = self._bound.get(expression.variable, frozenset()) | found
        body = self.types(expression.body, found if isinstance(expression, Each) else context)
        if isinstance(expression, Quantified):
            self.use(body)
            return frozenset()
        return body

    def _call(self, call: Call, context: Types) -> Types:
        found: list[Types] = []
        for argument in call.arguments:
            if isinstance(argument, Function):
                self._bound[argument.variable] = self._bound.get(argument.variable, frozenset()) | found[0]
            found.append(self.types(argument, context))
        if not call.arguments and call.function in ("string", "number", "string-length", "normalize-space"):
            found = [context]
        for types in found:
            if call.function in ("count", "boolean", "not", "name", "local-name", "namespace-uri"):
                self.use(types)
            else:
                self.value(types)
        signature = SAFE_FUNCTIONS[call.function]
        if call.function in MOTION_FUNCTIONS:
            self.use(frozenset({FRAME}))
        if signature.selects:
            return found[signature.place]
        if call.function == WINDOW:
            return frozenset({FRAME})
        # There are no attributes of type ID in MCML, so id() selects nothing; its types are kept anyway.
        return EVERYTHING if call.function == "id" else frozenset()

    def value(self, types: Types) -> None:
        """The string of these nodes is taken: the text of all that is in them."""
        self.use(types)
        self._head_text = self._head_text or bool(types & {DOCUMENT, MCML})
        for holder in types:
            # Text is in motion names only; frame_bones have none.
            self.use(_descendants().get(holder, frozenset()) & _FRAME_TYPES)

    def _predicates(self, predicates: tuple[Expression, ...], context: Types) -> None:
        for predicate in predicates:
            self.use(self.types(predicate, context))

    def _path(self, path: Path, context: Types) -> Types:
        current = frozenset({DOCUMENT}) if path.absolute else context
        if path.start is not None:
            current = self.types(path.start, context)
        for step in path.steps:
            following = self.step(current, step)
            if step.predicates:
                self.use(following)
                self._predicates(step.predicates, following)
            current = following
        return current

    def step(self, current: Types, step: Step) -> Types:
        """Types that a step reaches from nodes of these types, predicates aside."""
        # A node from which the step reaches any node matters, of any type.
        self.use(frozenset(source for source in current if reach(source, step)))
        return frozenset().union(*(reach(source, step) for source in current))


def reach(source: str, step: Step) -> Types:
    """Types that a step can reach from a node of a type, predicates aside."""
    return _reach(source, step.axis, step.name)


@lru_cache(maxsize=4096)
def _reach(source: str, axis: str, name: str) -> Types:
    return frozenset(found for found in _axis(source, axis) if _passes(found, axis, name))


def _passes(found: str, axis: str, name: str) -> bool:
    if name == "node()":
        return True
    if name == "text()":
        return found.startswith("#")
    if name.endswith(")"):
        return False
    if axis == "namespace":
        return True
    if axis == "attribute":
        return name == "*" or name in declarations()[found[1:]].attributes
    is_element = found[0] not in "#@/"
    return is_element and name in ("*", found)


def _axis(source: str, axis: str) -> Types:
    if axis == "self":
        return frozenset({source})
    if axis == "child":
        return _children().get(source, frozenset())
    if axis == "namespace":
        # Every element has one namespace node; it is kept as if it were an attribute.
        return frozenset({f"@{source}"}) if source in declarations() else frozenset()
    if axis == "attribute":
        declared = declarations().get(source)
        return frozenset({f"@{source}"}) if declared is not None and declared.attributes else frozenset()
    if axis == "descendant":
        return _descendants().get(source, frozenset())
    if axis == "descendant-or-self":
        return _descendants().get(source, frozenset()) | {source}
    if axis == "parent":
        return parent_types(source)
    if axis in ("ancestor", "ancestor-or-self"):
        above = frozenset(holder for holder, held in _descendants().items() if source.removeprefix("@") in held)
        own = frozenset({source[1:]}) if source.startswith("@") else frozenset()
        return above | own | (frozenset({source}) if axis == "ancestor-or-self" else frozenset())
    if axis in ("following-sibling", "preceding-sibling"):
        if source.startswith("@") or source == DOCUMENT:
            return frozenset()
        return frozenset().union(*(_children()[parent] for parent in parent_types(source)))
    if axis in ("following", "preceding"):
        return EVERYTHING
    return frozenset()


def parent_types(source: str) -> Types:
    """Types of the parents that nodes of a type can have."""
    if source.startswith("@"):
        return frozenset({source[1:]})
    return frozenset(holder for holder, held in _children().items() if source in held)


@cache
def _children() -> dict[str, Types]:
    found: dict[str, Types] = {DOCUMENT: frozenset({MCML})}
    for name, declaration in declarations().items():
        held = {tag for step in declaration.steps for tag in step}
        found[name] = frozenset(held | ({f"#{name}"} if declaration.kind == "text" else set()))
    return found


@cache
def _descendants() -> dict[str, Types]:
    found = dict(_children())
    changed = True
    while changed:
        wider = {name: held.union(*(found.get(tag, frozenset()) for tag in held)) for name, held in found.items()}
        changed, found = wider != found, wider
    return found


@cache
def _inside(tag: str) -> Types:
    """An element, all that can be in it, and their attributes."""
    inside = _descendants().get(tag, frozenset()) | {tag}
    return inside | {f"@{name}" for name in inside if not name.startswith("#")}


EVERYTHING: Types = frozenset({DOCUMENT}) | _descendants()[DOCUMENT]
"""All types but attributes: those no axis but `attribute` reaches."""
