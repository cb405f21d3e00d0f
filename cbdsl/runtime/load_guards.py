"""Load guards of a run: their bounds, how long each limited the motion, and the forces."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.control.load_guard import JOINT_PACE, LOAD_GUARD, PACE
from cbdsl.program.checked import Guards
from cbdsl.sensing.signals import Signals

# Time constant with which measured joint torques of an arm fade, s.
_MEMORY = 3.0


class LoadGuards:
    """Bounds of a program on the loads of fingers, hands and arms.

    Attributes:
        names: Names of the fingers, hands and arms.
        records: Records of ``LOAD_GUARD``, shape (g,).
        rows: Required rows of the signal table.

    Args:
        guards: Guards of the program.
        signals: Signals of the robot.
        period: Period of the control ticks, s.
    """

    def __init__(self, guards: Guards, signals: Signals, period: float) -> None:
        self._period = period
        self.names: list[str] = []
        records: list[dict[str, Any]] = []
        for name, (first, last), row, bound in _bounds(guards, signals):
            self.names.append(name)
            pace = PACE * period
            records.append({"first": first, "last": last, "row": row, "bound": bound, "pace": pace})
        self._strain, self._fading = signals.strain, math.exp(-period / _MEMORY)
        self._joints: list[tuple[int, NDArray[np.int64]]] = []
        for name, joints, row in _arms(guards, signals):
            self._joints.append((len(records), joints))
            self.names.append(name)
            own = {"bound": guards.joint_torque, "pace": JOINT_PACE * period}
            records.append({"row": row, "joints": len(joints), **own})
        self._strain.needed |= bool(self._joints)
        self.records: NDArray[Any] = np.zeros(len(records), LOAD_GUARD)
        for place, given in enumerate(records):
            for key, value in given.items():
                self.records[key][place] = value
        self.rows = self.records["row"].tolist()
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self.records["held"], self.records["torques"] = False, 0.0
        self._ticks = np.zeros(len(self.names), dtype=np.int64)
        self._most = np.zeros(len(self.names))

    # Let b be the bound of a guard, T the period, tau the time constant, s the measured torques and
    # m their memory. The kept norm is k = exp(-T / tau) min(|m|, b). If |s| >= k, m becomes s.
    # Otherwise m keeps its direction and gets the norm k.
    def note_strain(self) -> None:
        """Store the torques of arms before the tick.

        A rigid contact that has given way is over. Without a memory the next impact would be as
        fast as the last. So measured torques fade slowly, starting at the bound at most.
        """
        for number, joints in self._joints:
            guard, strain = self.records[number], self._strain.torques[joints]
            memory = guard["torques"][: len(joints)]
            before = math.hypot(*memory.tolist())
            kept = self._fading * min(before, guard["bound"])
            if math.hypot(*strain.tolist()) >= kept:
                memory[:] = strain
            else:
                # The former norm is not 0 here, because the kept one exceeds another norm.
                memory *= kept / before

    def note(self) -> None:
        """Count the ticks in which guards limited the motion, and keep the largest forces."""
        if self.names:
            self._ticks += self.records["held"]
            np.maximum(self._most, self.records["force"], out=self._most)

    @property
    def holding(self) -> tuple[str, ...]:
        """Names of the guards that limited the motion in the last tick."""
        return tuple(np.array(self.names)[self.records["held"]].tolist())

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the bounds."""
        return tuple("N m" if joints else "N" for joints in self.records["joints"])

    @property
    def clauses(self) -> tuple[str, ...]:
        """One clause for each guard that limited the motion: how long, and the largest force."""
        rows = zip(self.names, self.records["bound"], self._ticks, self._most, strict=True)
        return tuple(
            f"the guard of {name} ({bound:g} {unit}) held for {ticks * self._period:.1f} s, at "
            f"{most:.1f} {unit} at most"
            for (name, bound, ticks, most), unit in zip(rows, self.units, strict=True)
            if ticks
        )


def _arms(guards: Guards, signals: Signals) -> Iterator[tuple[str, NDArray[np.int64], int]]:
    """Yield name, joints and position row of each effector that has a tip."""
    for name, effector in signals.robot.effectors.items():
        if guards.joint_torque is not None and effector.tip is not None:
            joints = signals.joints.of(name)
            yield name, joints, signals.kinematic_rows.joints(name)


def _bounds(guards: Guards, signals: Signals) -> Iterator[tuple[str, tuple[int, int], int, float]]:
    """Yield name, load cells, row and bound of each guard."""
    for hand, cells in signals.robot.load_cells.items():
        first, last = signals.touch.span(hand)
        links = [cell.link for cell in cells.values()]
        if guards.finger_force is not None:
            for place, (finger, link) in enumerate(zip(cells, links, strict=True), first):
                row = signals.kinematic_rows.links([link])
                yield f"{hand}.{finger}", (place, place + 1), row, guards.finger_force
        if guards.hand_force is not None:
            yield hand, (first, last), signals.kinematic_rows.links(links), guards.hand_force
