"""Joint watch: newest joint states by name, and the reasons not to trust them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import Floats, Joints, RobotDocument
from cbdsl.extend.driver import Driver, JointSample
from cbdsl_drive.limiter import JointLimits

# A joint that exceeds its limit by less counts as standing at the limit, rad or m.
_SOFTNESS = 0.05
# Measured speeds are differences of noisy positions, and efforts are rounded.
_SPEEDS, _EFFORTS = 2.0, 1.05
# Joint states are frozen if they stay equal for so long by their stamps, s, while a reference
# moves so far, rad.
_FROZEN, _MOVED = 0.06, 0.02
# Messages of one publisher come in order: a stamp that goes back by more is a jump of its clock, s.
_BACK = 0.01


class JointWatch:
    """Newest states of all actuated joints.

    Args:
        robot: Robot with drivers.
        limits: Limits of its joints.

    Attributes:
        names: Actuated joints, n of them.
        positions, velocities, efforts: Newest states, shape (n,).
        measures_efforts: True if all joints have an effort.
        stamps: Times of the newest states by the robot's clock, s, shape (n,).
        clock_differs: True if a clock jumped, so that the robot has another time.
        stamp: Time of the newest state by the robot's clock, s; the oldest joint's counts.
    """

    def __init__(self, robot: RobotDocument, limits: JointLimits) -> None:
        self.names = Joints(robot).names
        self._limits, self._drivers = limits, robot.drivers
        count, index = len(self.names), {name: i for i, name in enumerate(self.names)}
        self.columns = {
            name: {driver.joints.get(joint, joint): index[joint] for joint in joints}
            for name, driver, joints in _reported(robot)
        }
        # Fingers that press against an object stand still while their references move on.
        self._pressing = np.zeros(count, dtype=bool)
        for cells in robot.load_cells.values():
            self._pressing[[index[cell.joint] for cell in cells.values()]] = True
        self.positions, self.velocities = np.zeros(count), np.zeros(count)
        self.efforts = np.full(count, np.nan)
        self.stamps, self._received = np.full(count, -np.inf), np.full(count, -np.inf)
        self._changed = np.full(count, -np.inf)
        self._sources = np.zeros(count, dtype=np.uint64)
        self.clock_differs = False
        # References at the last change of each driver's states, and the stamps of these changes.
        self._references = np.zeros(count)
        self._compared: dict[str, float] = {}

    @property
    def stamp(self) -> float:
        """Time of the oldest joint's newest state by the robot's clock, s."""
        return float(self.stamps.min())

    @property
    def measures_efforts(self) -> bool:
        """True if all joints have an effort."""
        return bool(np.isfinite(self.efforts).all())

    def note(self, sample: JointSample, now: float, wall: float) -> str:
        """Take in joint states.

        Args:
            sample: Joint states.
            now: Time of arrival by a monotonic clock, s.
            wall: Time of arrival by this computer's clock, s since the epoch.

        Returns:
            The reason why they cannot be trusted; empty if there is none.
        """
        driver, columns = self._drivers[sample.driver], self.columns[sample.driver]
        if problem := _malformed(sample):
            return problem
        if problem := _misstamped(sample, driver, wall):
            self.clock_differs = True
            return problem
        named = [(columns[name], i) for i, name in enumerate(sample.names) if name in columns]
        if not named:
            return ""
        ours, theirs = (np.array(side) for side in zip(*named, strict=True))
        if problem := self._second_source(sample, ours, now):
            return problem
        back = float(self.stamps[ours].max()) - sample.stamp
        if sample.source and back > _BACK:
            self.clock_differs = True
            return (
                f"joint states of driver '{sample.driver}' are stamped {back:.3f} s before earlier "
                "ones: the robot's clock was set back"
            )
        # Transports may deliver messages twice or in another order.
        fresh = sample.stamp > self.stamps[ours]
        ours, theirs = ours[fresh], theirs[fresh]
        if not len(ours):
            return ""
        self._take(sample, ours, theirs, now)
        return self._implausible(sample.driver, ours)

    def _second_source(self, sample: JointSample, ours: Floats, now: float) -> str:
        """Return the joint that another publisher reports at the same time."""
        recent = now - self._received[ours] <= self._drivers[sample.driver].deadline
        other = ours[recent & (self._sources[ours] != sample.source)]
        self._sources[ours] = sample.source
        if not len(other):
            return ""
        return f"two publishers send states of joint '{self.names[other[0]]}'"

    def _take(self, sample: JointSample, ours: Floats, theirs: Floats, now: float) -> None:
        positions = np.array(sample.positions)[theirs]
        elapsed = sample.stamp - self.stamps[ours]
        if sample.velocities:
            velocities = np.array(sample.velocities)[theirs]
        else:
            with np.errstate(invalid="ignore"):
                velocities = (positions - self.positions[ours]) / elapsed
            # The first sample has no predecessor: its elapsed time is infinite.
            velocities = np.where(np.isfinite(elapsed), velocities, 0.0)
        changed = positions != self.positions[ours]
        if sample.efforts:
            efforts = np.array(sample.efforts)[theirs]
            changed |= efforts != self.efforts[ours]
            self.efforts[ours] = efforts
        # Any change shows that the whole driver's measurement is running.
        if changed.any():
            self._changed[ours] = sample.stamp
        self.positions[ours], self.velocities[ours] = positions, velocities
        self.stamps[ours], self._received[ours] = sample.stamp, now

    def _implausible(self, driver: str, ours: Floats) -> str:
        """Return the limit that measured states exceed."""
        limits, positions = self._limits, self.positions
        beyond = np.maximum(limits.lower - positions, positions - limits.upper) > _SOFTNESS
        if (joint := self._first(beyond, ours)) is not None:
            return (
                f"joint '{self.names[joint]}' is at {positions[joint]:.3f}, outside of its limits "
                f"{limits.lower[joint]:.3f} to {limits.upper[joint]:.3f}"
            )
        fast = np.abs(self.velocities) > _SPEEDS * limits.velocity
        if (joint := self._first(fast, ours)) is not None:
            return (
                f"joint '{self.names[joint]}' moves at {self.velocities[joint]:.3f}/s, and its "
                f"limit is {limits.velocity[joint]:.3f}/s"
            )
        strong = np.abs(self.efforts) > _EFFORTS * limits.effort
        if (joint := self._first(strong, ours)) is not None:
            return (
                f"joint '{self.names[joint]}' has the effort {self.efforts[joint]:.2f}, and its "
                f"limit is {limits.effort[joint]:.2f}"
            )
        return ""

    @staticmethod
    def _first(wrong: NDArray[np.bool_], ours: Floats) -> int | None:
        hits = ours[wrong[ours]]
        return int(hits[0]) if len(hits) else None

    def unheard(self) -> Iterator[tuple[str, list[str]]]:
        """Yield each driver with joints that no message named, and these joints."""
        for driver, columns in self.columns.items():
            missing = [n for n, column in columns.items() if self._received[column] == -np.inf]
            if missing:
                yield driver, missing

    def overdue(self, now: float) -> str:
        """Return the driver and the joints whose states are older than its deadline."""
        for driver, columns in self.columns.items():
            own = np.array(list(columns.values()))
            ages, deadline = now - self._received[own], self._drivers[driver].deadline
            late = ages > deadline
            if late.any():
                names = [name for name, is_late in zip(columns, late, strict=True) if is_late]
                which = "any joint" if late.all() else f"joint {_listed(names)}"
                return (
                    f"no new state of {which} from driver '{driver}' for "
                    f"{1e3 * ages.max():.0f} ms (deadline {1e3 * deadline:.0f} ms)"
                )
        return ""

    def frozen(self, references: Floats) -> str:
        """Return the driver whose states stay equal while its references move."""
        for driver, columns in self.columns.items():
            own = np.array(list(columns.values()))
            latest = float(self._changed[own].max())
            # Motion of references is counted from the last change of the states.
            if latest != self._compared.get(driver):
                self._compared[driver] = latest
                self._references[own] = references[own]
                continue
            moved = np.abs(references[own] - self._references[own])[~self._pressing[own]]
            still = float(self.stamps[own].max()) - latest
            if still > _FROZEN and moved.size and moved.max() > _MOVED:
                return (
                    f"joint states of driver '{driver}' are frozen: all equal for "
                    f"{1e3 * still:.0f} ms while a reference moved by {moved.max():.3f}"
                )
        return ""

    def start_errors(self, references: Floats) -> str:
        """Return the joint whose first reference is too far from its measured position."""
        for driver, columns in self.columns.items():
            for column in columns.values():
                error = abs(references[column] - self.positions[column])
                if not error <= self._drivers[driver].start:
                    return (
                        f"the first reference of joint '{self.names[column]}' is {error:.3f} from "
                        f"its position, and at most {self._drivers[driver].start:.3f} are allowed"
                    )
        return ""


def _reported(robot: RobotDocument) -> Iterator[tuple[str, Driver, list[str]]]:
    """Yield each driver with joint states, and the joints that it reports."""
    reporting = {name: driver for name, driver in robot.drivers.items() if driver.states}
    moved = {
        name: [joint for effector in driver.moves for joint in robot.joints(effector)]
        for name, driver in reporting.items()
    }
    claimed = {joint for joints in moved.values() for joint in joints}
    others = [joint for joint in Joints(robot).names if joint not in claimed]
    for name, driver in reporting.items():
        yield name, driver, moved[name] or others


def _malformed(sample: JointSample) -> str:
    """Return the reason why a message is no joint state."""
    source = f"driver '{sample.driver}'"
    if len(set(sample.names)) < len(sample.names):
        doubled = next(name for name in sample.names if sample.names.count(name) > 1)
        return f"{source} names joint '{doubled}' twice in one joint state"
    for key in ("positions", "velocities", "efforts"):
        values: Sequence[float] = getattr(sample, key)
        if len(values) != len(sample.names) and (values or key == "positions"):
            return f"{source} sends {len(values)} {key} for {len(sample.names)} joints"
        for name, value in zip(sample.names, values, strict=False):
            # Robots without torque sensors may fill efforts with NaN.
            if not math.isfinite(value) and key != "efforts":
                return f"{source} sends {value} in {key} of joint '{name}'"
    return ""


def _misstamped(sample: JointSample, driver: Driver, wall: float) -> str:
    """Return the reason why a stamp cannot be the time of a fresh measurement."""
    age = wall - sample.stamp
    if -driver.skew <= age <= driver.skew + driver.deadline:
        return ""
    direction = "ahead of" if age < 0 else "behind"
    return (
        f"joint states of driver '{sample.driver}' are stamped {abs(age):.3f} s {direction} this "
        f"computer's clock: a clock jumped, or they are stale (skew at most {driver.skew:.3f} s)"
    )


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:4])
    return shown if len(names) <= 4 else f"{shown} and {len(names) - 4} more"
