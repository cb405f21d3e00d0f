"""Supervisor: the safety contract between a program and a real robot, as a state machine.

    off -> ready     all joints and sensors received, clocks and limits agree, one commander
    ready -> running the first reference, near the measured positions
    any -> held      a deadline, a lost peer, the emergency stop, a limit, a tracking error, a halt
    held -> off      a person, and nothing else

References pass in ``ready`` and ``running`` only, and through the limiter.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import Enum
from itertools import chain

import numpy as np

from cbdsl.extend.backend import Floats, RobotDocument
from cbdsl.extend.driver import (
    CameraSample,
    DescriptionSample,
    FaultSample,
    ImageSample,
    JointSample,
    PublishersSample,
    RegionsSample,
    Sample,
    StopSample,
    UrdfModel,
    WrenchSample,
    absolute,
    horizon,
)
from cbdsl_drive.description import description_problems
from cbdsl_drive.joint_limits import joint_limits
from cbdsl_drive.joint_watch import JointWatch
from cbdsl_drive.limiter import COMPUTING, STANDING, Limiter
from cbdsl_drive.motion_watch import MotionWatch
from cbdsl_drive.sensor_watch import SensorWatch
from cbdsl_drive.stop_watch import StopWatch
from cbdsl_drive.survey import StreamProblem

# A reference is at its measured position, rad or m; and the most steps on the way there.
_SETTLED, _MOST_STEPS = 1e-4, 20


class State(Enum):
    """State of the contract."""

    OFF = "off"
    READY = "ready"
    RUNNING = "running"
    HELD = "held"


class SafetySupervisor:
    """State machine that decides when references pass, for any transport.

    Args:
        robot: Robot with drivers.
        model: URDF of the robot.
        period: Control period, s.
        ideal: True if cameras send regions, and no images.

    Attributes:
        state: State of the contract.
        cause: Reason of the last hold, as a sentence without a full stop; empty before.
        joints, sensors: Newest samples.
        limiter: References that passed.
    """

    def __init__(
        self, robot: RobotDocument, model: UrdfModel, period: float, *, ideal: bool = False
    ) -> None:
        limits = joint_limits(robot, model)
        self._robot, self._model, self._period, self._ideal = robot, model, period, ideal
        self.joints = JointWatch(robot, limits)
        self.sensors = SensorWatch(robot, ideal=ideal)
        self.limiter = Limiter(limits, period)
        self._motion, self._stops = MotionWatch(robot, period), StopWatch(robot)
        # Stamp of the joint states that were compared with references last.
        self._watched = -np.inf
        self.state, self.cause = State.OFF, ""
        self._limits = limits
        # Mismatches of the current approach to ``ready``, in order of discovery; and the addresses
        # of joint states that cannot be read.
        self._mismatches: dict[str, str] = {}
        # Differences between each driver's description of the robot and its document.
        self._differences: dict[str, list[str]] = {}
        # Positions that a held robot returns to; ``None`` if its joint states are not trusted.
        self._target: Floats | None = None
        self._settling = 0
        self._described = {name for name, d in robot.drivers.items() if d.description}
        # The longest time between two checks, s.
        self._patience = min((d.deadline for d in robot.drivers.values()), default=np.inf)
        self._checked: float | None = None
        # Time of the newest reference, and the time after which controllers hold still, s.
        self._admitted = -np.inf
        self._pause = min(
            (horizon(d, 1.0 / period) for d in robot.drivers.values()), default=3.0 * period
        )

    @property
    def patience(self) -> float:
        """Longest time between two checks, s.

        A robot that stands is not endangered by a program that computes for longer, such as a path
        around obstacles: its controllers hold still, and no reference is sent before a new state.
        """
        speeds = np.abs(self.limiter.velocities)
        is_standing = float(speeds.max(initial=0.0)) < STANDING
        return max(self._patience, COMPUTING) if is_standing else self._patience

    @property
    def is_undescribed(self) -> bool:
        """True if a driver's description of the robot has not come."""
        return bool(self._described)

    def is_late(self, now: float) -> bool:
        """Return whether the last check of a running robot is longer ago than its deadline.

        Args:
            now: Time by a monotonic clock, s.
        """
        late = 0.0 if self._checked is None else now - self._checked
        return self.state is State.RUNNING and late > self._period + self._patience

    @property
    def passes(self) -> bool:
        """True if references pass."""
        return self.state in (State.READY, State.RUNNING)

    def note(self, sample: Sample, now: float, wall: float) -> None:
        """Take in a sample; a faulty one holds the robot.

        Args:
            sample: Sample.
            now: Time of arrival by a monotonic clock, s.
            wall: Time of arrival by this computer's clock, s since the epoch.
        """
        self._require_prompt(now)
        if problem := self._problem(sample, now, wall):
            # Before a robot is ready, a wrong message is an obstacle to report. Afterwards it is a
            # hold.
            if self.state is State.OFF:
                malformed = isinstance(sample, JointSample)
                states = self._robot.drivers[sample.driver].states
                self._mismatches[problem] = (states or "") if malformed else ""
            self._hold_if_active(problem, blind=isinstance(sample, JointSample))

    def _problem(self, sample: Sample, now: float, wall: float) -> str:
        match sample:
            case JointSample():
                return self.joints.note(sample, now, wall)
            case WrenchSample():
                return self.sensors.note_wrench(sample, now)
            case ImageSample() | RegionsSample():
                return self.sensors.note_view(sample, now)
            case CameraSample():
                return self.sensors.note_camera(sample)
            case DescriptionSample():
                return self._compare(sample)
            case StopSample():
                problem = self._stops.note(sample, now)
                return problem if self.passes else ""
            case PublishersSample():
                problem = self._stops.note_publishers(sample, now)
                return problem if self.passes else ""
            case FaultSample():
                return sample.cause if self.passes else ""

    def _compare(self, sample: DescriptionSample) -> str:
        self._described.discard(sample.driver)
        names = self._robot.drivers[sample.driver].joints
        problems = description_problems(sample.urdf, self._model, self.joints.names, names)
        self._differences[sample.driver] = problems
        return problems[0] if problems and self.passes else ""

    def obstacles(self, surveyed: Iterable[StreamProblem] = (), now: float = -np.inf) -> list[str]:
        """Return every reason against ``ready``, one sentence each.

        Args:
            surveyed: Problems of streams that the transport found.
            now: Time by a monotonic clock, s.
        """
        return list(dict.fromkeys(self._obstacles(list(surveyed), now)))

    def _obstacles(self, surveyed: list[StreamProblem], now: float) -> Iterator[str]:
        if self.state is State.HELD:
            yield f"the robot is held: {self.cause}"
        yield from (problem.text for problem in surveyed)
        yield from self._mismatches
        yield from chain.from_iterable(self._differences.values())
        # These explain why nothing is received; a second diagnostic would not help.
        explained = {absolute(problem.address) for problem in surveyed}
        explained.update(absolute(address) for address in self._mismatches.values() if address)
        for address, text in self._unheard():
            if absolute(address) not in explained:
                yield text
        yield from self._stops.unsure(now)
        for driver in self._stops.pressed():
            yield f"the emergency stop of driver '{driver}' is pressed"

    def _unheard(self) -> Iterator[tuple[str, str]]:
        """Yield the address of each stream without a message, and a sentence."""
        drivers = self._robot.drivers
        for driver, names in self.joints.unheard():
            topic = drivers[driver].states or ""
            yield topic, f"no state of {_joints(names)} from driver '{driver}' at {topic}"
        yield from self.sensors.unheard()
        for driver in sorted(self._described):
            topic = drivers[driver].description or ""
            yield topic, f"no description of the robot from driver '{driver}' at {topic}"
        yield from self._stops.unheard()

    def forget_mismatches(self) -> None:
        """Forget the diagnostics so far, so that only persistent ones are found again."""
        self._mismatches.clear()

    def make_ready(self, now: float) -> None:
        """Enter ``ready``; ``obstacles`` has to be empty."""
        assert self.state is State.OFF, f"ready follows off, and the state is {self.state.value}"
        self.limiter.reset(self.joints.positions)
        self.state, self._checked = State.READY, now

    def resume(self, now: float) -> None:
        """Count all times from now on, after a pause in which the robot stood."""
        self._checked = now
        self.sensors.excuse(now)

    def check(self, now: float) -> None:
        """Hold the robot if a deadline has passed or it does not follow; to be called each tick."""
        if not self.passes:
            return
        self._require_prompt(now)
        self._checked = now
        # Without joint states, positions are unknown: the robot brakes, and does not return to
        # them.
        if problem := self.joints.overdue(now):
            self._hold_if_active(problem, blind=True)
        if problem := self.sensors.overdue(now):
            self._hold_if_active(problem)
        for problem in self._stops.unsure(now, moves=True):
            self._hold_if_active(problem)
        if self.state is State.RUNNING and self.joints.stamp > self._watched:
            self._watched = self.joints.stamp
            references, positions = self.limiter.positions, self.joints.positions
            if problem := self.joints.frozen(references):
                self._hold_if_active(problem, blind=True)
            # Another controller would fight against a return to the measured positions.
            if problem := self._motion.strayed(positions, self.joints.stamps, now):
                self._hold_if_active(problem, blind=True)
            if problem := self._motion.stuck(references, positions, now):
                self._hold_if_active(problem)

    def _require_prompt(self, now: float) -> None:
        """Hold a robot whose program did nothing for longer than a deadline."""
        late = 0.0 if self._checked is None else now - self._checked
        if self.state is State.RUNNING and late > self._period + self.patience:
            self.hold(f"this process was suspended for {1e3 * late:.0f} ms", blind=True)

    def admit(self, reference: Floats, now: float) -> Floats | None:
        """Return the references that may be sent; ``None`` if none may.

        Args:
            reference: Requested positions, rad or m, shape (n,).
            now: Time by a monotonic clock, s.
        """
        self._require_prompt(now)
        if not self.passes:
            return None
        broken = np.flatnonzero(~np.isfinite(reference))
        if len(broken):
            joint = self.joints.names[broken[0]]
            self._hold_if_active(f"the program's reference of joint '{joint}' is not finite")
            return None
        if self.state is State.READY:
            # The robot may have been moved since it was ready.
            self.limiter.reset(self.joints.positions)
            if problem := self.joints.start_errors(reference):
                self._hold_if_active(problem)
                return None
            self.state, self._checked = State.RUNNING, now
            self._motion.begin(self.joints.positions, self.joints.stamps, now)
        self._admitted = now
        references = self.limiter.approach(reference)
        self._motion.command(references, now)
        return references

    def settle(self, now: float) -> Floats | None:
        """Return the next references of a held robot; ``None`` once it stands.

        Joints that moved when it was held brake, and the others return to their measured positions,
        unless joint states are the cause. After a pause its controllers hold still already, and
        nothing is sent.

        Args:
            now: Time by a monotonic clock, s.
        """
        if self.state is not State.HELD or now - self._admitted > self._pause:
            return None
        self._admitted = now
        if self._target is None:
            return None if self.limiter.stands else self.limiter.brake()
        before = self.limiter.positions
        self._settling += 1
        near = np.nanmax(np.abs(before - self._target), initial=0.0) < _SETTLED
        # The number of steps is bounded, because the limiter may not reach a position outside of
        # the limits.
        if self.limiter.stands and (near or self._settling > _MOST_STEPS):
            return None
        if self._settling > _MOST_STEPS:
            return self.limiter.brake()
        return self.limiter.approach(self._target)

    def hold(self, cause: str, *, blind: bool = False) -> None:
        """Hold the robot until a person releases it; the first cause is kept.

        Args:
            cause: Sentence without a full stop.
            blind: True if joint states are not to be trusted.
        """
        if self.state is State.HELD:
            return
        active, self.state, self.cause = self.passes, State.HELD, cause
        self._settling = 0
        if blind or not active:
            self._target = None
            return
        # A joint that stands presses towards its reference, and returns. One that moves brakes, and
        # one far from its reference does, too.
        measured, references = self.joints.positions, self.limiter.positions
        brakes = self._motion.lagging(references, measured)
        brakes |= np.abs(self.joints.velocities) > STANDING
        self._target = np.where(brakes, np.nan, measured)

    def _hold_if_active(self, cause: str, *, blind: bool = False) -> None:
        if self.passes:
            self.hold(cause, blind=blind)

    def release(self) -> None:
        """Leave ``held`` by a person's decision, and enter ``off``."""
        if self.state is State.HELD:
            self.state = State.OFF

    def rest(self) -> None:
        """Enter ``off``: all samples have to be received again.

        A held robot rests after its release, and a running one after a hold.
        """
        assert self.state in (State.OFF, State.READY), f"a robot that is {self.state.value} moves"
        self.joints = JointWatch(self._robot, self._limits)
        self.sensors = SensorWatch(self._robot, ideal=self._ideal)
        self._mismatches.clear()
        self.state = State.OFF


def _joints(names: list[str]) -> str:
    quoted = ", ".join(f"'{name}'" for name in names[:4])
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return f"joint{'s' if len(names) > 1 else ''} {quoted}{more}"
