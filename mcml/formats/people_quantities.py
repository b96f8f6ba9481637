"""Quantities of the gait model of everybody in a clip. With several people their names begin with a prefix, as those of
a file do: `Anna:LKneeAngles`, `Anna:cgm1:LKneeAngles`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

from mcml.formats.c3d.analog import Channels
from mcml.formats.gait_markers import FindPositions
from mcml.formats.gait_quantities import ComputedQuantity, FindGround, GaitQuantities, Ids
from mcml.laboratory.gait_model.model_markers import find_people
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Array

FindGroundOf: TypeAlias = Callable[[str | None], FindGround]
"""The ground's reaction on the feet of a person, by the prefix; None for the only one."""


class PeopleQuantities:
    """The quantities of everybody in a clip; arguments as of `GaitQuantities`.

    people: the prefixes of their markers, where there are several; () for one or none.
    """

    def __init__(self, head: ClipHead, channels: Channels | None, *, has_plates: bool) -> None:
        self.people = find_people(head.skeleton)
        wanted = self.people or (None,)
        self._by_person = {one: GaitQuantities(head, channels, has_plates=has_plates, person=one) for one in wanted}
        self._of_all = GaitQuantities(head, channels, has_plates=has_plates)

    def of(self, person: str | None) -> GaitQuantities:
        """The quantities of a person, by the prefix; None for the only one, and of several for those of nobody."""
        return self._by_person.get(person, self._of_all)

    def describe(self, stated: Sequence[str]) -> Iterator[ComputedQuantity]:
        """Yield every quantity that the file lacks, as `GaitQuantities.describe`. stated: names in the file."""
        for person, quantities in self._by_person.items():
            begin = f"{person}:" if person else ""
            own = [name.rpartition(":")[2] if person is None else name.removeprefix(begin) for name in stated]
            for each in quantities.describe(own):
                yield replace(each, name=begin + each.name)

    def lacks(self, name: str) -> str | None:
        """Why a quantity cannot be computed, "" where it can, None for a name that is no quantity of the model."""
        _, quantities, bare = self._find(name)
        return quantities.lacks(bare)

    def unit(self, name: str) -> str:
        """The unit of a quantity, "" for a name that is no quantity of the model."""
        _, quantities, bare = self._find(name)
        return quantities.unit(bare)

    def values(
        self, name: str, axis: int, ids: Ids, find_positions: FindPositions, find_ground: FindGroundOf | None
    ) -> Array:
        """(n,) of a quantity in frames with these ids; NaN in frames that are not of the file."""
        person, quantities, bare = self._find(name)
        return quantities.values(bare, axis, ids, find_positions, None if find_ground is None else find_ground(person))

    def _find(self, name: str) -> tuple[str | None, GaitQuantities, str]:
        """(person, the person's quantities, name without the person); of a name without a person those of all."""
        for person in sorted(self.people, key=len, reverse=True):
            if person and name.startswith(f"{person}:"):
                return person, self.of(person), name.removeprefix(f"{person}:")
        only = "" if "" in self.people else None
        return only, self.of(only), name
