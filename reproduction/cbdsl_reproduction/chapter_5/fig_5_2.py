"""Expected motion after an object was shaken in front of the robot (Figure 5.2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.control import Kinematics
from cbdsl.api.shipped import shipped_robot
from cbdsl_reproduction.chapter_4.posture_density import PostureDensity
from cbdsl_reproduction.chapter_5.motion_episodes import (
    EFFECTOR,
    NOTHING,
    SHAKEN,
    MotionEpisode,
    motion_digest,
    run_motion_episodes,
)
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_trials import kept_trials
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import at_least, at_most, below

Floats = NDArray[np.float64]
Limits = Mapping[str, tuple[float, float]]

_ROBOT = "dexter"
_TRIALS, _QUICK_TRIALS, _EPISODES = 20, 1, 25
# Standard deviation of a kernel, rad, as in the densities that are learned with policies.
_BANDWIDTH = 0.1
# Distance from the tracked object, deg; share of trials with one peak, %; share of episodes that
# track motion although nothing moves, %.
_CLOSE, _MOST, _FEW = 5.0, 80, 5
_DRAWS = 200

_PLACE = "Section 5.2.1, Figure 5.2"
_SEEN = Claim(_PLACE, "motion tracked where something is shaken", "%", "no number")
_PHANTOMS = Claim(_PLACE, "motion tracked where nothing moves", "%", "no peak", at_most(_FEW))
_OFF = Claim(
    _PLACE,
    "from the middle of the shaken object, when tracked",
    "deg",
    "where it was presented",
    below(_CLOSE),
)
_SINGLE = Claim(_PLACE, "trials whose density has a single peak", "%", "one peak", at_least(_MOST))
CLAIMS: Claims = {"fig-5.2": (_SEEN, _PHANTOMS, _OFF, _SINGLE)}

_NOTES = (
    "25 episodes a trial, in every second of which a thing is shaken 4 cm to either side, 1.1 to "
    "1.3 m in front of the robot, from any posture of the head with ten looks. The head rests for "
    "0.8 s where it looks: while it turns, everything moves in its images. A moved object is "
    "assumed to stay there until the camera rests again. Searches are drawn uniformly, and not "
    "from learned models.",
)


def run(settings: RunSettings) -> Result:
    """Search for motion, and evaluate the postures that track it."""
    count = settings.trials or (_QUICK_TRIALS if settings.quick else _TRIALS)
    seeds = {
        context: [s for trial in range(count) for s in seeds_of(trial, context, settings.seed)]
        for context in (SHAKEN, NOTHING)
    }
    episodes = kept_trials(
        settings.folder / f"motion_{settings.backend}_{settings.cameras}.jsonl",
        seeds,
        motion_digest,
        MotionEpisode,
        partial(run_motion_episodes, engine=settings.backend, cameras=settings.cameras),
        settings.progress,
    )
    limits = _limits()
    densities = [
        _density(f"fig-5.2-trial-{trial}", "", _trial(episodes, trial, settings.seed), limits)
        for trial in range(count)
    ]
    quantities = (*_tracked(episodes), *_peaks(densities, settings.seed))
    title = "Where motion was tracked, first trial (Figure 5.2 b)"
    first = _trial(episodes, 0, settings.seed)
    return Result(quantities, (_density("fig-5.2", title, first, limits),), _NOTES)


def seeds_of(trial: int, context: str, first: int) -> list[int]:
    """Return the seeds of a trial's episodes in one of both contexts, which alternate."""
    numbers = range(trial * _EPISODES, (trial + 1) * _EPISODES)
    # The parity restarts in each trial, whose number of
    # episodes is odd: objects are shaken in 13 of 25.
    return [first + n for n in numbers if (n % _EPISODES % 2 == 0) == (context == SHAKEN)]


def _trial(
    episodes: Mapping[str, Sequence[MotionEpisode]], trial: int, first: int
) -> list[MotionEpisode]:
    own = {s for context in (SHAKEN, NOTHING) for s in seeds_of(trial, context, first)}
    return [each for kept in episodes.values() for each in kept if each.seed in own]


def _density(
    name: str, title: str, episodes: Sequence[MotionEpisode], limits: Limits
) -> PostureDensity:
    postures = np.array([each.posture for each in episodes if each.posture]).reshape(-1, 2)
    return PostureDensity(name, title, postures, _BANDWIDTH, limits)


def _tracked(episodes: Mapping[str, Sequence[MotionEpisode]]) -> Iterator[Quantity]:
    """Yield the shares of episodes that track motion, and the angle to the shaken object."""
    shaken, nothing = episodes[SHAKEN], episodes[NOTHING]
    tracked = [each for each in shaken if each.posture]
    yield percentage(_SEEN, len(tracked), len(shaken), of="episodes")
    seen = sum(bool(each.posture) for each in nothing)
    yield percentage(_PHANTOMS, seen, len(nothing), of="episodes")
    yield mean_of(_OFF, [math.degrees(each.off) for each in tracked])


def _peaks(densities: Sequence[PostureDensity], seed: int) -> Iterator[Quantity]:
    """Yield the share of densities with a single peak."""
    # A single peak means little if postures drawn at
    # random have one, too. The note counts such draws.
    single = sum(len(each.peaks()) == 1 for each in densities)
    yield percentage(
        _SINGLE,
        single,
        len(densities),
        note=f"of as many postures anywhere, {_by_chance(densities, seed)} of {_DRAWS} draws",
    )


def _by_chance(densities: Sequence[PostureDensity], seed: int) -> int:
    """Return the number of draws of uniformly distributed postures with a single peak."""
    rng, first = np.random.default_rng(seed), densities[0]
    ends = np.array([*first.limits.values()])
    drawn = (
        rng.uniform(ends[:, 0], ends[:, 1], size=(len(first.postures), 2)) for _ in range(_DRAWS)
    )
    draws = (PostureDensity("", "", each, first.bandwidth, first.limits) for each in drawn)
    return sum(len(each.peaks()) == 1 for each in draws)


def _limits() -> Limits:
    robot, urdf = shipped_robot(_ROBOT)
    kinematics = Kinematics(robot, urdf)
    columns = kinematics.joints.of(EFFECTOR)
    return {
        joint: (float(kinematics.lower[column]), float(kinematics.upper[column]))
        for joint, column in zip(robot.joints(EFFECTOR), columns, strict=True)
    }
