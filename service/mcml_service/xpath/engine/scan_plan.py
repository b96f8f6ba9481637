"""The plan of a query about samples: a condition on frames, and the result for each frame.

`//frame[frame_bone[@name='A']/@Rx > frame_bone[@name='B']/@Rx]`, `//frame_bone[@name='A'][@Rx > 45]/@Ry` and similar
queries never read other bones.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcml.language.vocabulary import FRAME, FRAME_BONE, MCML, MOTION
from mcml.motion.skeleton import CHANNEL_INDEX
from mcml_service.xpath.engine.samples.condition import Condition
from mcml_service.xpath.language.conditions import (
    Sample,
    any_bone_condition,
    attribute_conditions,
    bone_conditions,
    condition,
    conjunction,
    present,
    sample,
)
from mcml_service.xpath.language.labels import motion_name_groups
from mcml_service.xpath.language.tree import Expression, Path


@dataclass(frozen=True)
class ScanPlan:
    """The plan of a scan.

    condition: on a frame, or on a frame_bone if `any_bone`. lead: name of the bone whose tracks are read, None for all
    bones. names: groups of motion names; the frame must have one name of each group. target: "frame" or "frame_bone".
    bone: the name of the resulting frame_bone, None for any that fulfils the condition (or all of the frame, without
    such a condition). attribute: of the target.
    """

    condition: Condition
    lead: str | None
    names: tuple[tuple[str, ...], ...]
    target: str
    bone: str | None
    attribute: str | None

    @property
    def any_bone(self) -> bool:
        return self.lead is None

    @property
    def sample(self) -> Sample | None:
        """The queried sample, if the target is a channel that every hit has."""
        channel = CHANNEL_INDEX.get(self.attribute or "")
        found = None if channel is None or self.target == FRAME else sample(self.bone, channel)
        return found if found in self.condition.strict else None

    @property
    def one_each(self) -> bool:
        """Whether every frame (or track) that fulfils the condition gives exactly one node."""
        if self.target == FRAME:
            return self.attribute in (None, "id") and not self.any_bone
        own = any(each.bone == self.bone for each in self.condition.strict)
        return own and (self.attribute in (None, "name") or self.sample is not None)


def plan_scan(tree: Expression) -> ScanPlan | None:
    """The plan of a node set, in the form of `rules.normal`; None where samples do not decide it."""
    if not isinstance(tree, Path) or not tree.absolute or len(tree.steps) < 3:
        return None
    ways = [(step.axis, step.name) for step in tree.steps[:3]]
    if ways != [("child", MCML), ("child", MOTION), ("child", FRAME)] or any(s.predicates for s in tree.steps[:2]):
        return None
    names: list[tuple[str, ...]] = []
    conditions: list[Expression] = []
    steps = tree.steps[3:]
    of_any = False
    for predicate in tree.steps[2].predicates:
        groups = motion_name_groups(predicate)
        found = condition(predicate, FRAME) if groups is None else None
        if groups is None and found is None:
            # A condition on any frame_bone is possible only for one frame_bone, without conditions on others.
            alone = not of_any and all(step.axis == "attribute" for step in steps)
            found, of_any = (any_bone_condition(predicate) if alone else None), True
        if groups is None and found is None:
            return None
        names += groups or ()
        conditions += [found] if found is not None else []
    target, bone = FRAME, None
    if steps and steps[0].name == FRAME_BONE:
        compiled = bone_conditions(steps[0])
        if compiled is None:
            return None
        target, (bone, own), steps = FRAME_BONE, compiled, steps[1:]
        conditions += own
    attribute = None
    if steps:
        compiled_attribute = attribute_conditions(steps[0], bone) if len(steps) == 1 else None
        if compiled_attribute is None or (target == FRAME and compiled_attribute[1]):
            return None
        attribute, on_attribute = compiled_attribute
        conditions += on_attribute
    if target == FRAME_BONE and attribute in CHANNEL_INDEX:
        conditions.append(present(sample(bone, CHANNEL_INDEX[attribute])))
    if not conditions:
        return None
    whole = Condition.of(conjunction(conditions))
    if not whole.strict:
        return None
    lead = None
    if not any(each.bone is None for each in whole.samples):
        bounded = [each.bone for each, _, _ in whole.bounds if each in whole.strict]
        lead = next(iter([*bounded, *sorted(each.bone or "" for each in whole.strict)]))
    elif not any(each.bone is None for each in whole.strict):
        return None
    return ScanPlan(whole, lead, tuple(names), target, bone, attribute)
