"""Markers of a person as the gait model takes them: by its names, in millimetres, with virtual ones.

They are read twice: in the whole recording of the kept file, which tells the subject, and in frames of the clip, whose
edits count.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.quantities import decode_text
from mcml.formats.c3d.subjects import read_sample
from mcml.formats.gait_properties import read_virtual_markers
from mcml.laboratory.gait_model.model_markers import find_model_markers, find_segments
from mcml.laboratory.gait_model.virtual_markers import VirtualMarker
from mcml.motion.clip import ClipHead
from mcml.motion.landmarks.tables import key_of
from mcml.motion.skeleton import Array
from mcml.motion.units import UNITS, metres_of

FindPositions: TypeAlias = Callable[[Sequence[int]], Array]
"""Returns (n, k, 3) positions of joints of the skeleton in the frames asked for, in the unit of the clip."""

_MILLIMETRES: Final = 1000.0
_FAR: Final = 5.0
"""Millimetres (rms) of markers of a segment from their places in standing, from which they may have been moved."""


class GaitMarkers:
    """The markers of a person in a clip.

    head: of the clip. file: the kept file, None without one that has points. person: the prefix of the markers, where
    there are several people. found: by the names of the model. virtual: those that other markers carry.
    """

    def __init__(self, head: ClipHead, file: Channels | None, person: str | None) -> None:
        self._head, self._file = head, file
        self.found = find_model_markers(head.skeleton, person)
        self.virtual = self.choose_virtual(dict(read_virtual_markers(head.properties, person or "")))[0]

    @cached_property
    def _labels(self) -> dict[str, int]:
        """Joints of the person's markers, by the part of their labels that is compared."""
        return {
            key_of(joint.source_name.rpartition(":")[2]): index
            for index, joint in reversed(list(enumerate(self._head.skeleton.joints)))
            if joint.source_name.rpartition(":")[0].strip() == self.found.prefix
        }

    def choose_virtual(self, virtual: Mapping[str, VirtualMarker]) -> tuple[dict[str, VirtualMarker], list[str]]:
        """(virtual markers that the clip lacks, by markers that it has; notes about others).

        A joint whose lateral marker and wand the clip has gets no note, because the gait model needs no more.
        """
        chosen, notes = {}, []
        for name, marker in virtual.items():
            if name in self.found.joints:
                continue
            own = {self._bare(label): place for label, place in marker.places.items() if key_of(label) in self._labels}
            known = VirtualMarker(own).known_by(own)
            joint = {f"{name[0]}{each}" for each in (("KNE", "THI") if "Knee" in name else ("ANK", "TIB"))}
            if known is None and not joint <= self.found.joints.keys():
                notes.append(f"{name} stays unknown: fewer than three markers of its segment are in both trials")
            elif known is not None:
                chosen[name] = known
        return chosen, notes

    def check_virtual(self, virtual: Mapping[str, VirtualMarker], find_positions: FindPositions) -> list[str]:
        """Notes about virtual markers whose carriers are not where they were in standing."""
        notes = []
        places = self.label_all(find_positions) if virtual else {}
        for name, marker in virtual.items():
            away = marker.locate(places)[1]
            known = away[np.isfinite(away)]
            if not len(known) or np.median(known) > _FAR:
                far = f"{np.median(known):.0f} mm (rms) off their places in standing" if len(known) else "never seen"
                notes.append(f"{name} may be wrong: the markers that carry it are {far}")
        return notes

    @property
    def names(self) -> list[str]:
        """Of all markers that the model can use."""
        return [*self.found.joints, *self.virtual]

    @property
    def labels(self) -> dict[str, str]:
        """Labels in the file, without a prefix, of the markers by the names of the model."""
        return {name: source.rpartition(":")[2].strip() for name, source in self.found.sources.items()}

    @cached_property
    def joints(self) -> list[int]:
        """Joints of the skeleton that are read, each once."""
        carriers = [self._labels[key_of(label)] for marker in self.virtual.values() for label in marker.places]
        return list(dict.fromkeys([*self.found.joints.values(), *carriers]))

    def name(self, positions: Array) -> dict[str, Array]:
        """(n, 3) of each marker. positions: (n, k, 3) of `joints` in frames of the clip, in its unit."""
        scaled = positions * self._clip_to_millimetres
        return self._name({joint: np.ascontiguousarray(scaled[:, place]) for place, joint in enumerate(self.joints)})

    @cached_property
    def sample(self) -> dict[str, Array]:
        """(n, 3) of each marker in the kept file; unknown in one frame without a file."""
        return self._name({joint: self.whole[:, joint] for joint in self.joints})

    def _name(self, by_joint: Mapping[int, Array]) -> dict[str, Array]:
        markers = {name: by_joint[joint] for name, joint in self.found.joints.items()}
        for name, marker in self.virtual.items():
            carriers = {label: by_joint[self._labels[key_of(label)]] for label in marker.places}
            markers[name] = marker.locate(carriers)[0]
        return markers

    def label_all(self, find_positions: FindPositions | None) -> dict[str, Array]:
        """(n, 3) millimetres of all markers of the person, by their labels without a prefix.

        find_positions: where there is no kept file.
        """
        joints = list(self._labels.values())
        whole = self.whole[:, joints]
        if self._file is None and find_positions is not None:
            whole = find_positions(joints) * self._clip_to_millimetres
        return {self._bare(key): whole[:, place] for place, key in enumerate(self._labels)}

    def _bare(self, label: str) -> str:
        """The label of this clip, without its prefix, that is the same as a label."""
        source = self._head.skeleton.joints[self._labels[key_of(label)]].source_name
        return source.rpartition(":")[2].strip()

    def segments(self) -> dict[str, str]:
        """Segments of labels, as `find_virtual_markers` takes them."""
        return find_segments(self._head.skeleton, self.found.prefix)

    @cached_property
    def whole(self) -> Array:
        """(n, joints, 3) millimetres of the kept file; unknown in one frame without a file."""
        labels, _, read = self.read
        places = {label: index for index, label in reversed(list(enumerate(labels)))}
        positions = np.full((max(1, len(read)), len(self._head.skeleton), 3), np.nan)
        for index, joint in enumerate(self._head.skeleton.joints):
            if (place := places.get(joint.source_name.strip())) is not None:
                positions[:, index] = read[:, place] * self.to_millimetres
        return positions

    @cached_property
    def read(self) -> tuple[list[str], NDArray[np.intp], Array]:
        """Labels, frames and positions of the file, as `read_sample` returns them."""
        return ([], np.arange(0), np.empty((0, 0, 3))) if self._file is None else read_sample(self._file)

    @property
    def _clip_to_millimetres(self) -> float:
        """Of a unit of the clip; of millimetres where it states none."""
        metres = metres_of(self._head)
        return 1.0 if metres is None else metres * _MILLIMETRES

    @property
    def to_millimetres(self) -> float:
        """Of a unit of the file's points; millimetres where it states none."""
        texts = [] if self._file is None else self._file.said.texts("POINT:UNITS")
        return UNITS.get(decode_text(texts[0]).lower() if texts else "", 1 / _MILLIMETRES) * _MILLIMETRES
