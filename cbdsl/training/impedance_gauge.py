"""Impedance gauge: load and displacement of a hand in each test of an episode.

It reads the robot's own load cells and joints only, no data of the simulator.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.kinematics.rotation import log
from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller, Relative
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.signals import Signals
from cbdsl.types.direction import AXES, KINDS
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import is_tip, record_of
from cbdsl.types.state import Predicate

Floats = NDArray[np.float64]

# Number of ticks over which loads are averaged: 0.1 s on Dexter.
_TICKS = 6


class _Probe(NamedTuple):
    """Program that tests one direction.

    Attributes:
        load: Controller that tracks a load along one axis.
        motion: Feedback of the moved tip.
        axis: Index of the axis.
        sign: Sign of the reference.
    """

    load: Controller
    motion: Resource
    axis: int
    sign: int

    @property
    def direction(self) -> str:
        """Name of the direction in profiles."""
        return KINDS[self.load.feedback.type.name] + AXES[self.axis]


def _probe(program: CheckedProgram) -> _Probe | None:
    """Return how a program tests a direction; ``None`` if it does not."""
    primitives = [
        primitive
        for action in program.actions
        if action.composition is not None
        for primitive in action.composition.primitives
    ]
    controllers = [each for action in program.actions for each in action.controllers]
    # A test is recognized by two controllers. One is rewarded for a change of the hand's load along
    # or about a single axis. The other one controls the position of a tip for a force, or its
    # orientation for a torque.
    for load in (each for primitive in primitives for each in primitive.earners):
        reference, kind = load.reference, load.feedback.type.name
        is_net = record_of(load.feedback.source).sums and load.feedback.type.factors == 1
        if not is_net or kind not in KINDS:
            continue
        if load.axes is None or len(load.axes) != 1 or not isinstance(reference, Relative):
            continue
        wanted = "position" if kind == "force" else "orientation"
        for motion in (each.feedback for each in controllers):
            if is_tip(motion.source) and motion.type.name == wanted:
                sign = 1 if sum(reference.offset) > 0.0 else -1
                return _Probe(load, motion, load.axes[0], sign)
    return None


def _tests_of(program: CheckedProgram) -> tuple[tuple[str, ...], dict[str, _Probe]]:
    """Return the actions that lead to the program with tests, and its tests by action."""
    used = [(action.name, action.program) for action in program.actions if action.program]
    probes = {
        name: probe
        for name, own in used
        # A program that uses other programs has more purposes than a test.
        if all(each.program is None for each in own.actions) and (probe := _probe(own)) is not None
    }
    if probes:
        return (), probes
    for name, own in used:
        path, probes = _tests_of(own)
        if probes:
            return (name, *path), probes
    return (), {}


class _Outset(NamedTuple):
    """Start of the outward motion of a test.

    Attributes:
        pose: Pose of the tip.
        load: Load of the hand at that pose.
        free: Load of the hand while it bears its object alone.
    """

    pose: Floats
    load: Floats
    free: Floats


#: Marker of a test whose outward motion has ended.
_OVER = _Outset(np.zeros(0), np.zeros(0), np.zeros(0))


# A test has four parts: the hand waits, moves outwards against a load, stops, and returns.
# Displacement and loads are measured as components along or about the axis of the test. The
# displacement is that of the tip during the outward motion. The load is the mean of the last ticks
# of this motion minus the mean of the last ticks before it. The resistance is the mean over the
# whole motion minus the median during the wait, when the hand bears its object alone. The residue
# is the distance of the tip from its start after the return. Impedance is load over displacement
# (Eq 7.10). The model assumes that the grip does not slip, and that the displacement is small
# enough for one rotation vector.
class ImpedanceGauge(EpisodeObserver):
    """Listener to the ticks of an episode that makes a profile of its tests.

    The tests are those of the program itself, or of the first program that it uses and that has
    some.
    """

    def __init__(self, program: CheckedProgram) -> None:
        self._path, self._probes = _tests_of(program)
        self._name = ""
        self._start: Floats = np.zeros(0)
        self._begun: _Outset | None = None
        self._loads: deque[Floats] = deque(maxlen=_TICKS)
        self._free: list[Floats] = []
        self._way: list[Floats] = []
        self._tests: list[ImpedanceTest] = []

    @property
    def listens(self) -> bool:
        """Whether the program has tests to listen to."""
        return bool(self._probes)

    @property
    def profile(self) -> ImpedanceProfile:
        """Profile of the completed tests."""
        return ImpedanceProfile(tuple(self._tests))

    def note_tick(self, tick: Tick) -> None:
        """Process a tick."""
        run = self._testing(tick.run)
        name = "" if run is None or run.action is None else run.action.name
        if name != self._name:
            self._leave(tick.signals)
        probe = self._probes.get(name)
        if probe is None or run is None:
            return
        if name != self._name:
            self._name = name
            self._start, self._begun, self._free = self._pose(probe, tick.signals), None, []
            self._loads.clear()
        self._follow(probe, run.children[name], tick.signals)

    def finish(self, signals: Signals) -> ImpedanceProfile:
        """Finish the episode and return its profile."""
        self._leave(signals)
        return self.profile

    def _testing(self, run: ProgramRun) -> ProgramRun | None:
        """Return the run of the program with the tests; ``None`` while another action is active."""
        for name in self._path:
            if run.action is None or run.action.name != name:
                return None
            run = run.children[name]
        return run

    def _follow(self, probe: _Probe, run: ProgramRun, signals: Signals) -> None:
        """Note the start of a test, and the test itself when its outward motion ends."""
        load = signals.read(probe.load.feedback)
        active = [each.run for each in run.active()]
        tests = any(each.controller.name == probe.load.name for each in active)
        if tests and self._begun is None and self._loads:
            borne = np.mean(self._loads, axis=0)
            # The first impact is measured a tick before the wait is over.
            free = np.median(self._free, axis=0) if self._free else borne
            self._begun = _Outset(self._pose(probe, signals), borne, free)
            self._loads.clear()
            self._way = []
        elif not tests and self._begun is not None and self._begun is not _OVER:
            self._note_test(probe, self._begun, signals, tracked=run.rewarded)
            self._begun = _OVER
        if load is None or self._begun is _OVER:
            return
        self._loads.append(load.value.copy())
        if self._begun is not None:
            self._way.append(load.value.copy())
        elif any(_waits(each) for each in active):
            self._free.append(load.value.copy())

    def _note_test(self, probe: _Probe, begun: _Outset, signals: Signals, *, tracked: bool) -> None:
        moved = _moved(probe, begun.pose, self._pose(probe, signals))
        if not self._way or math.isnan(moved):
            return
        change = float((np.mean(self._loads, axis=0) - begun.load)[probe.axis])
        resistance = float((np.mean(self._way, axis=0) - begun.free)[probe.axis])
        self._tests.append(
            ImpedanceTest(
                probe.direction, probe.sign, moved, change, tracked, resistance=resistance
            )
        )

    def _leave(self, signals: Signals) -> None:
        """Note the hand's remaining displacement when a test is left."""
        probe = self._probes.get(self._name)
        if probe is not None and self._begun is not None and self._begun is not _OVER:
            # A test that neither settled nor ended in time has not tracked its load.
            self._note_test(probe, self._begun, signals, tracked=False)
            self._begun = _OVER
        if probe is not None and self._begun is _OVER and self._tests:
            residue = abs(_moved(probe, self._start, self._pose(probe, signals)))
            self._tests[-1] = self._tests[-1]._replace(residue=residue)
        self._name, self._begun = "", None

    @staticmethod
    def _pose(probe: _Probe, signals: Signals) -> Floats:
        reading = signals.read(probe.motion)
        return np.full(3, math.nan) if reading is None else reading.value.copy()


def _waits(run: ControllerRun) -> bool:
    """Return whether a controller waits for a load to set in; its object hangs free meanwhile."""
    return run.controller.onset is not None and run.predicate == Predicate.UNDEFINED


def _moved(probe: _Probe, before: Floats, after: Floats) -> float:
    """Return the displacement along or about the axis of a test, m or rad."""
    if probe.motion.type.name == "position":
        return float((after - before)[probe.axis])
    # The logarithm is the rotation vector of the turn from before to after, in the world frame.
    return float(log(after @ before.T)[probe.axis])
