"""Episodes in which a robot searches for motion (Section 5.2.1)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cbdsl.api.sensing import EpisodeListeners, Tick
from cbdsl_reproduction.simulation_fixture import SimulationFixture, simulation_fixture
from cbdsl_reproduction.trial_digest import trial_digest

PROGRAM, STAGE, EFFECTOR = "watch_for_motion", "shaken", "head"
#: Contexts of the stage: an object is shaken, or nothing moves.
SHAKEN, NOTHING = "shaken", "nothing"
# The first look begins with a transition. Ten looks have two each: on the way, and there. Tracking
# takes three more.
_TRANSITIONS = 24


class MotionEpisode(NamedTuple):
    """Episode of a search for motion.

    Attributes:
        things: Context of the episode.
        seed: Seed of the episode.
        posture: Posture of the head that tracks motion, rad; empty if motion was not tracked.
        off: Final angle between the cameras' mean line of sight and the centre of the shaken
            object, by the simulator's ground truth, rad; NaN if no object was shaken.
        ending: Ending of the program.
    """

    things: str
    seed: int
    posture: tuple[float, ...]
    off: float
    ending: str


class _EpisodeEye:
    """Observer of an episode and of the simulator's ground truth."""

    def __init__(self, lab: SimulationFixture) -> None:
        self._truth, self._things = lab.backend.truth, tuple(lab.stage.things)
        self._cameras = [camera.link for camera in lab.robot.cameras.values()]
        self._middle: np.ndarray[Any, Any] | None = None
        self._last: Tick | None = None

    def note(self, tick: Tick) -> None:
        """Record a tick."""
        if self._last is None:
            # An object is shaken about its initial position.
            shown = [name for name in self._things if name in self._truth.names()]
            self._middle = self._truth.pose(shown[0]).position if shown else None
        self._last = tick

    @property
    def posture(self) -> tuple[float, ...]:
        """Final joint angles of the head, rad."""
        if self._last is None:
            return ()
        columns = self._last.signals.joints.of(EFFECTOR)
        return tuple(round(float(a), 4) for a in self._last.observation.positions[columns])

    @property
    def off(self) -> float:
        """Angle from the cameras' mean line of sight to the centre of the shaken object, rad."""
        if self._middle is None or self._last is None:
            return math.nan
        frames = [self._last.signals.kinematics.frame(link) for link in self._cameras]
        # The x axis of a camera's frame is its optical axis.
        looks = np.mean([frame.rotation[:, 0] for frame in frames], axis=0)
        way = self._middle - np.mean([frame.position for frame in frames], axis=0)
        # Rounding can put the cosine beyond 1, for which ``acos`` is undefined.
        cosine = looks @ way / (np.linalg.norm(looks) * np.linalg.norm(way))
        return math.acos(min(max(float(cosine), -1.0), 1.0))


def motion_digest(context: str) -> str:
    """Return the digest of all inputs of episodes except context, seed and engine."""
    return trial_digest(PROGRAM, {}, STAGE)


def run_motion_episodes(
    context: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[MotionEpisode]:
    """Search for motion, once for each seed.

    Args:
        context: Context of the stage.
        seeds: Seeds of the episodes.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
    """
    with simulation_fixture(PROGRAM, None, STAGE, engine, cameras) as lab:
        runner = replace(lab, program=lab.program._replace(transitions=_TRANSITIONS)).runner()
        for seed in seeds:
            watcher = _EpisodeEye(lab)
            result = runner.run(
                lab.stage, seed, context, observer=EpisodeListeners(on_tick=watcher.note)
            )
            posture = watcher.posture if result.rewarded else ()
            yield MotionEpisode(context, seed, posture, watcher.off, result.ending)
