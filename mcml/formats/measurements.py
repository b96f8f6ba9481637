"""Measurements of a file beside the motion: quantities of a laboratory's own model, analog channels, force plates.

The values are those of the file: edits of the motion do not change them. They belong to frames by the numbers that the
frames have in the file. Of signals with several samples a frame, the value of a frame is that of their means.
Quantities of the gait model that the file lacks are computed from the markers of the clip.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.errors import NotFoundError
from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.plates import plates_of
from mcml.formats.c3d.quantities import Quantity, kept_quantities, rate_of, samples_at
from mcml.formats.gait_markers import FindPositions
from mcml.formats.gait_properties import is_baseline_asked
from mcml.formats.gait_quantities import Ids
from mcml.formats.people_quantities import PeopleQuantities
from mcml.formats.quantity_units import are_per_kilogram, explain_unit
from mcml.laboratory.force_plates import Plate, PlateForces, plate_forces
from mcml.laboratory.gait_events import SIDES, GaitEvent, Side, WalkerPaths
from mcml.laboratory.gait_model.dynamics import Ground
from mcml.laboratory.plate_feet import FootForces, find_loads, find_step_events, sum_forces
from mcml.motion.bodies.quantities import AXES_OF_FILE, AskedQuantity
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Array

FindWalker: TypeAlias = Callable[[str | None], WalkerPaths]
"""The feet of a person, by the prefix of the markers; of the only one without it."""

BEYOND_CAPTURES: Final = 10_000_000
"""Ids of frames that are of no file are larger: 28 hours at 100 Hz."""

NAMED: Final = 60
"""Limit of names in an error."""

_SAME_RATE: Final = 1e-4
"""Relative difference of two statements of one rate, which rounding does not reach."""

_LETTERS: Final[Mapping[str, Side]] = {"L": "left", "R": "right"}

_OF_MODEL: Final = "C3D files of a model, such as Plug-in Gait,"
_OF_TRIAL: Final = "C3D files, and TRC with a table of forces, whose uploads are kept,"

_OF_PLATES: Final = {"force": ("N", AXES_OF_FILE), "cop": ("m", AXES_OF_FILE), "free-moment": ("N m", ())}
"""Unit and axes of the functions of force plates."""


@dataclass(frozen=True)
class Measurement:
    """function: that asks for it, such as "quantity". name: its first argument, as the file writes it.

    axes: values of its second argument. unit: as the file writes it, "" where it does not state it. group: such as
    "ANGLES". rate: samples a second, None for one a frame. known: whether frames of the clip may have values; reason:
    why not. notes: assumptions about facts that it does not state.
    """

    function: str
    name: str
    axes: tuple[str, ...]
    unit: str
    group: str
    rate: float | None = None
    known: bool = True
    reason: str = ""
    notes: tuple[str, ...] = ()


class Measurements:
    """The measurements of the file of a clip.

    head: of the clip. read: reads the analog channels of the file, where it is kept; without it, quantities alone are
    known.
    """

    def __init__(self, head: ClipHead, read: Callable[[], Channels] | None = None) -> None:
        self._head = head
        self._read = read
        self._plates_read: dict[str, PlateForces] = {}

    def describe(self) -> list[Measurement]:
        """Every measurement, in the order of the file; computed quantities after its own."""
        return self._list_quantities() + self._list_computed() + self._list_channels() + self._list_plates()

    def values(
        self,
        asked: AskedQuantity,
        ids: NDArray[np.int64] | Sequence[str],
        find_walker: FindWalker | None = None,
        find_positions: FindPositions | None = None,
    ) -> Array:
        """(n,) of the frames with these numbers in the file, NaN where it states none, or is of another frame rate.

        find_walker: returns the feet in these frames, in metres, for forces on "left" and "right" ("Anna:left" of
        several people), and for computed loads. find_positions: returns joints in these frames. Raises NotFoundError
        for a measurement that the file does not have, RequestError for an unknown axis, and the errors of find_walker.
        """
        asked.check_joints(())
        name, *rest = asked.arguments
        axis = AXES_OF_FILE.index(rest[0]) if rest else 0
        if asked.name == "quantity":
            return self._quantity(name, axis, ids, find_walker, find_positions)
        if asked.name == "analog":
            return self._at(self._channel(name), ids)
        person, _, side = name.rpartition(":")
        if side in SIDES and self._plates and find_walker is not None:
            return _component(self._on_foot(side, ids, find_walker(person or None)), asked.name, axis)
        return self._at(_component(self._forces(name), asked.name, axis), ids)

    def plates_at(self, ids: NDArray[np.int64] | Sequence[str]) -> dict[int, PlateForces]:
        """Mean forces in the frames with these numbers, by the number of each plate that can be used, from 1."""
        return {
            number: replace(
                forces,
                force=self._at(forces.force, ids),
                centre_of_pressure=self._at(forces.centre_of_pressure, ids),
                free_moment=self._at(forces.free_moment, ids),
            )
            for number in self._usable_plates
            for forces in [self._forces(str(number))]
        }

    @property
    def plate_corners(self) -> dict[str, Array]:
        """(4, 3) metres of each plate that can be used, by its name."""
        return {str(number): self._plates[number - 1].corners for number in self._usable_plates}

    @property
    def samples(self) -> int:
        """Samples of a plate in a frame; 0 without analog channels."""
        return 0 if self.channels is None else self.channels.samples

    def sample_plate(self, number: int, frame: int, count: int) -> PlateForces:
        """Forces on a usable plate in all samples of so many frames, from the one with this number in the file on.

        There are fewer frames at the end of the file. The sign is that of the whole recording.
        """
        assert self.channels is not None
        plate = self._plates[number - 1]
        samples = self.channels.read(frame - self.channels.first, count, plate.channels)
        return plate_forces(plate, samples, is_turned=self._forces(str(number)).is_turned)

    def find_events(self, ids: NDArray[np.int64] | Sequence[str], walker: WalkerPaths) -> list[GaitEvent]:
        """Strikes and offs of whole steps on force plates, in seconds from the first of these frames.

        walker: the feet in these frames, in metres.
        """
        channels, numbers = self.channels, np.asarray(ids)
        if channels is None or numbers.dtype.kind != "i" or self.rate_difference:
            return []
        plates = self.plates_at(ids)
        usable = list(plates)

        def read_upward(place: int, at: int) -> Array | None:
            frame = int(numbers[at])
            if int(numbers[at + 1]) != frame + 1 or not 0 <= frame - channels.first < channels.frames - 1:
                return None
            forces = self.sample_plate(usable[place], frame, 2)
            upward: Array = forces.force @ forces.vertical
            return upward

        forces, surfaces = list(plates.values()), [self._plates[number - 1] for number in usable]
        sampling = channels.samples, channels.rate
        return find_step_events(find_loads(forces, walker), surfaces, forces, walker, sampling, read_upward)

    def _at(self, whole: Array, ids: NDArray[np.int64] | Sequence[str]) -> Array:
        """Values of frames (n, …) from those of all frames of the file."""
        values = np.full((len(ids), *whole.shape[1:]), np.nan)
        numbers = np.asarray(ids)
        if self.channels is not None and not self.rate_difference and numbers.dtype.kind == "i":
            places = numbers - self.channels.first
            inside = (places >= 0) & (places < len(whole))
            values[inside] = whole[places[inside]]
        return values

    def _on_foot(self, side: Side, ids: NDArray[np.int64] | Sequence[str], walker: WalkerPaths) -> FootForces:
        plates = list(self.plates_at(ids).values())
        if not plates:
            gone = np.full((len(ids), 3), np.nan)
            return FootForces(gone, gone, gone[:, 0])
        return sum_forces(plates, find_loads(plates, walker), side)

    def unit(self, asked: AskedQuantity) -> str:
        """The unit of a quantity or a channel, stated by the file or computed; "" where it is unknown."""
        name = asked.arguments[0]
        if asked.name != "quantity":
            units = {each.name: each.unit for each in self._list_channels()}
            return units.get(name, "")
        quantity = self._find_stated(name)
        return self.gait.unit(name) if quantity is None else self._unit_of(quantity)[0]

    def _quantity(
        self,
        label: str,
        axis: int,
        ids: Ids,
        find_walker: FindWalker | None,
        find_positions: FindPositions | None,
    ) -> Array:
        quantity = self._find_stated(label)
        if quantity is None:
            lacks = self.gait.lacks(label)
            if lacks or find_positions is None:
                raise NotFoundError(
                    f"The file of this document has no quantity {label!r}, and it cannot be computed: {lacks}.",
                    remedy="Add the missing markers or measures to the file, or ask for another quantity.",
                )
            if lacks is None:
                raise _name_error("quantity", label, list(self.quantities), _OF_MODEL)
            find_ground = None if find_walker is None else lambda person: partial(self._ground, find_walker, person)
            return self.gait.values(label, axis, ids, find_positions, find_ground)
        if not quantity.has_rate(rate_of(self._head)):
            return np.full(len(ids), np.nan)
        samples = samples_at(quantity, ids)
        values: Array = np.where(samples[:, 3] < 0, np.nan, samples[:, axis])
        return values

    def _find_stated(self, label: str) -> Quantity | None:
        """A quantity of the file, by its label or, if only one has it, by the label without the subject."""
        if label in self.quantities:
            return self.quantities[label]
        same = [own for name, own in self.quantities.items() if name.rpartition(":")[2] == label]
        return same[0] if len(same) == 1 else None

    def _ground(
        self, find_walker: FindWalker, person: str | None, letter: str, places: NDArray[np.intp], count: int
    ) -> Ground:
        """The ground's reaction on a foot in all frames of the file, at their instants. places: of the frames asked for
        in the file."""
        walker = find_walker(person)
        known = places >= 0

        def spread(path: Array) -> Array:
            whole = np.full((count, 3), np.nan)
            whole[places[known]] = path[known]
            return whole

        walker = replace(
            walker,
            heels={side: spread(path) for side, path in walker.heels.items()},
            toes={side: spread(path) for side, path in walker.toes.items()},
            pelvis=spread(walker.pelvis),
            across=spread(walker.across),
        )
        usable = self._usable_plates
        loads = find_loads([self._forces(str(number)) for number in usable], walker)
        # Forces around the instant of a frame: the means of its samples are half a frame later.
        instants = [self._instants(number) for number in usable]
        foot = sum_forces(instants, loads, _LETTERS[letter])
        return Ground(foot.force, foot.centre_of_pressure, foot.free_moment[:, None] * instants[0].vertical)

    def _instants(self, number: int) -> PlateForces:
        """Forces of a plate around the instant of each frame of the file."""
        plate, channels = self._plates[number - 1], self.channels
        assert channels is not None
        return plate_forces(plate, channels.means(plate.channels, around_instant=True))

    def _channel(self, label: str) -> Array:
        """(frames of the file,) means of the samples of a channel."""
        labels = self.channels.labels if self.channels is not None else ()
        if self.channels is None or label not in labels:
            raise _name_error("analog channel", label, labels, _OF_TRIAL)
        return self.channels.means([labels.index(label)])[:, 0]

    def _forces(self, name: str) -> PlateForces:
        names = [str(number + 1) for number in range(len(self._plates))]
        if name not in names or self.channels is None:
            raise _name_error("force plate", name, names, _OF_TRIAL)
        if name not in self._plates_read:
            plate = self._plates[names.index(name)]
            samples = np.zeros((self.channels.frames, 0)) if plate.problems else self.channels.means(plate.channels)
            rate = self.channels.rate / self.channels.samples
            self._plates_read[name] = plate_forces(plate, samples, rate)
        return self._plates_read[name]

    def _list_quantities(self) -> list[Measurement]:
        rate = rate_of(self._head)
        items = []
        for label, quantity in self.quantities.items():
            known, (unit, notes) = quantity.has_rate(rate), self._unit_of(quantity)
            reason = "" if known else _other_rate(quantity.rate, rate)
            items.append(Measurement("quantity", label, AXES_OF_FILE, unit, quantity.group, None, known, reason, notes))
        return items

    def _list_computed(self) -> list[Measurement]:
        return [
            Measurement(
                "quantity", each.name, AXES_OF_FILE, each.unit, each.group, None, not each.reason, each.reason,
                each.notes,
            )
            for each in self.gait.describe(list(self.quantities))
        ]  # fmt: skip

    def _unit_of(self, quantity: Quantity) -> tuple[str, tuple[str, ...]]:
        """(unit, notes) of a quantity of the file."""
        return explain_unit(quantity, per_kilogram=self._are_per_kilogram)

    @cached_property
    def _are_per_kilogram(self) -> bool:
        return are_per_kilogram(self.quantities.values())

    def _list_channels(self) -> list[Measurement]:
        channels = self.channels
        if channels is None:
            return []
        rate = channels.rate if math.isfinite(channels.rate) else None
        return [
            Measurement("analog", label, (), unit, "ANALOG", rate, not self.rate_difference, self.rate_difference)
            for label, unit in zip(channels.labels, channels.units, strict=True)
        ]

    def _list_plates(self) -> list[Measurement]:
        rate = self.channels.rate if self.channels is not None else None
        items = []
        for number, plate in enumerate(self._plates, 1):
            reason = "; ".join(plate.problems) or self.rate_difference
            items += [
                Measurement(
                    function, str(number), axes, unit, f"FORCE_PLATFORM type {plate.type}", rate, not reason, reason,
                    plate.assumptions,
                )
                for function, (unit, axes) in _OF_PLATES.items()
            ]  # fmt: skip
        if any(item.known for item in items):
            items += [
                Measurement(function, f"{person}:{side}".lstrip(":"), axes, unit, "FORCE_PLATFORM by foot", rate)
                for person in self.gait.people or ("",)
                for side in SIDES
                for function, (unit, axes) in _OF_PLATES.items()
            ]
        return items

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """By label, as the file writes it; of equal labels the first."""
        part = next((source for source in self._head.sources if source.part == "c3d"), None)
        labelled: dict[str, Quantity] = {}
        for quantity in kept_quantities(part.sections) if part is not None else ():
            labelled.setdefault(quantity.label, quantity)
        return labelled

    @cached_property
    def gait(self) -> PeopleQuantities:
        """Quantities that are computed from markers."""
        has_plates = bool(self._usable_plates) and not self.rate_difference
        return PeopleQuantities(self._head, self._file, has_plates=has_plates)

    @cached_property
    def _file(self) -> Channels | None:
        return None if self._read is None else self._read()

    @property
    def channels(self) -> Channels | None:
        """The analog channels of the file, None where it has none."""
        return self._file if self._file is not None and len(self._file) else None

    @property
    def _usable_plates(self) -> list[int]:
        """Numbers, from 1, of the plates that can be used."""
        return [number for number, plate in enumerate(self._plates, 1) if not plate.problems]

    @cached_property
    def _plates(self) -> list[Plate]:
        is_asked = is_baseline_asked(self._head.properties)
        return [] if self.channels is None else plates_of(self.channels, subtract_baseline=is_asked)

    @cached_property
    def rate_difference(self) -> str:
        """Why frames of the clip are not those of the analog channels, "" where they may be."""
        seconds, channels = self._head.seconds_per_frame(), self.channels
        if channels is None or seconds is None or not math.isfinite(channels.rate):
            return ""
        rate = channels.rate / channels.samples
        same = abs(rate * seconds - 1) < _SAME_RATE
        return "" if same else _other_rate(f"{rate:g}", rate_of(self._head))


def _component(forces: PlateForces | FootForces, function: str, axis: int) -> Array:
    """(n,) of a function of force plates."""
    if function == "free-moment":
        return forces.free_moment
    component: Array = (forces.force if function == "force" else forces.centre_of_pressure)[:, axis]
    return component


def _other_rate(of_file: str, of_clip: str) -> str:
    return f"the file has {of_file} frames a second, the document {of_clip}"


def _name_error(kind: str, name: str, names: Sequence[str], where: str) -> NotFoundError:
    remedy = f"It has: {', '.join(names[:NAMED])}." if names else f"Only {where} have any."
    return NotFoundError(f"The file of this document has no {kind} {name!r}.", remedy=remedy)
