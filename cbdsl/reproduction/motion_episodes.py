"""Episodes in which a robot looks for something that moves (Section 5.2.1)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cbdsl.reproduction.simulation_fixture import SimulationFixture, simulation_fixture
from cbdsl.reproduction.trial_digest import trial_digest
from cbdsl.runtime.episode import Tick

PROGRAM, STAGE, EFFECTOR = "watch_for_motion", "shaken", "head"
#: Contexts of the stage: something is shaken, or nothing moves.
SHAKEN, NOTHING = "shaken", "nothing"
# Ten looks have two transitions each: on the way, and there. Tracking takes three more.
_TRANSITIONS = 23


class MotionEpisode(NamedTuple):
    """One episode.

    Attributes:
        things: its context.
        seed: of the episode.
        posture: of the head where motion was tracked, rad; empty where it was not.
        off: angle in the end between where the cameras looked and the middle of what was shaken,
            by the simulator's truth, rad; NaN where nothing was.
        ending: of the program.
    """

    things: str
    seed: int
    posture: tuple[float, ...]
    off: float
    ending: str


class _EpisodeEye:
    """Takes in an episode, and what the simulator's truth says of it."""

    def __init__(self, lab: SimulationFixture) -> None:
        self._truth, self._things = lab.backend.truth, tuple(lab.stage.things)
        self._cameras = [camera.link for camera in lab.robot.cameras.values()]
        self._middle: np.ndarray[Any, Any] | None = None
        self._last: Tick | None = None

    def note(self, tick: Tick) -> None:
        """Take in a tick."""
        if self._last is None:
            # A thing is shaken about where it is at first.
            shown = [name for name in self._things if name in self._truth.names()]
            self._middle = self._truth.pose(shown[0]).position if shown else None
        self._last = tick

    @property
    def posture(self) -> tuple[float, ...]:
        """Joint angles of the head in the end, rad."""
        if self._last is None:
            return ()
        columns = self._last.signals.joints.of(EFFECTOR)
        return tuple(round(float(a), 4) for a in self._last.observation.positions[columns])

    @property
    def off(self) -> float:
        """Angle between the cameras' mean line of sight and the middle of what was shaken, rad."""
        if self._middle is None or self._last is None:
            return math.nan
        frames = [self._last.signals.kinematics.frame(link) for link in self._cameras]
        looks = np.mean([frame.rotation[:, 0] for frame in frames], axis=0)
        way = self._middle - np.mean([frame.position for frame in frames], axis=0)
        cosine = looks @ way / (np.linalg.norm(looks) * np.linalg.norm(way))
        return math.acos(min(max(float(cosine), -1.0), 1.0))


def motion_digest(context: str) -> str:
    """Digest of all that decides episodes beside context, seed and engine."""
    return trial_digest(PROGRAM, {}, STAGE)


def run_motion_episodes(
    context: str, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[MotionEpisode]:
    """Look for motion, once for each seed.

    Args:
        context: of the stage.
        seeds: of the episodes.
        engine, cameras: of the simulation.

    Raises:
        BackendError, EpisodeError: the simulator cannot run it.
        ImportError: it is not installed.
    """
    with simulation_fixture(PROGRAM, None, STAGE, engine, cameras) as lab:
        runner = replace(lab, program=lab.program._replace(transitions=_TRANSITIONS)).runner()
        for seed in seeds:
            watcher = _EpisodeEye(lab)
            result = runner.run(lab.stage, seed, context, on_tick=watcher.note)
            posture = watcher.posture if result.rewarded else ()
            yield MotionEpisode(context, seed, posture, watcher.off, result.ending)
