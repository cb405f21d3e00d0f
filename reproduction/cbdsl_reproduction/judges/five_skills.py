"""The five skills of Chapter 4, learned from scratch bottom up, and judged by held-out episodes.

A trial works in a folder that has the shipped programs and robots first. A skill uses the policies
that were learned in that folder before. The folder of each seed is kept until the process ends.
"""

from __future__ import annotations

import atexit
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import cbdsl
from cbdsl.api.shipped import shipped_folder
from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition

# Seed of the first held-out episode of each trial, and their number.
_HELD_OUT, _EPISODES = 900_000, 50
# Least share of rewarded held-out episodes of a learned skill.
_LEAST = 0.8
_POLICIES = Path("knowledge") / "policies"


@dataclass(frozen=True)
class LearnedSkill:
    """Policy to learn.

    Attributes:
        program: Program of the policy.
        stage: Stage of the learning.
        episodes: Number of episodes.
        constants: Constants of the learner.
        transition_time: Maximum time of an action without a change of state, s.
        idle_time: Maximum time without a predicate of 0, s.
        episode_time: Maximum time of an episode, s.
        held_out: Stage of the held-out episodes, unless it is the stage of the learning.
    """

    program: str
    stage: str
    episodes: int
    constants: Mapping[str, str] = field(default_factory=dict)
    transition_time: float | None = None
    idle_time: float | None = None
    episode_time: float | None = None
    held_out: str = ""

    @property
    def shown(self) -> str:
        """Stage of the held-out episodes."""
        return self.held_out or self.stage


#: Skills by the name of their policies, bottom up. Actions may take as long as in the source, or
#: less where waiting teaches nothing, least while nothing moves.
SKILLS: Mapping[str, LearnedSkill] = {
    "searchtrack": LearnedSkill("searchtrack", "searchtrack_training", 50),
    "searchtrack_table": LearnedSkill("searchtrack", "table_training", 50),
    "tactileprobe": LearnedSkill(
        "tactileprobe", "held_right", 25, {"density": "gaussian", "prior": "25"}
    ),
    "reachtouch": LearnedSkill(
        "reachtouch",
        "reachtouch_training",
        25,
        {"exploring_episodes": "15"},
        transition_time=8.0,
        idle_time=1.0,
    ),
    "visualinspect": LearnedSkill(
        "visualinspect",
        "visualinspect_training",
        50,
        transition_time=5.0,
        held_out="spotted_right",
    ),
    # Without a limit, a search for objects out of reach takes hours of simulated time.
    "bimanualtouch": LearnedSkill(
        "bimanualtouch",
        "bimanualtouch_training",
        25,
        episode_time=300.0,
        held_out="table_right",
    ),
}


@cache
def folder_of(seed: int, backend: str) -> Path:
    """Return the folder of a trial, with the shipped programs and robots."""
    folder = Path(mkdtemp(prefix=f"cb_five_skills_{backend}_{seed}_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for part in ("robots", "programs"):
        shutil.copytree(shipped_folder() / part, folder / part)
    return folder


def learned(name: str, seed: int, body: BodyChoice) -> Path:
    """Learn a skill and all skills below it, unless they are in the folder, and return its policy.

    Raises:
        UsageError, OSError: As ``cbdsl.learn_trials``.
    """
    folder = folder_of(seed, body.backend)
    for own, skill in SKILLS.items():
        policy = folder / _POLICIES / f"{own}.yaml"
        if not policy.exists():
            request = cbdsl.LearnRequest(
                program=cbdsl.load(_file(folder, skill), stage=skill.stage, folder=folder),
                out=policy,
                episodes=skill.episodes,
                seed=seed,
                backend=body.backend,
                cameras=body.cameras,
                constants=skill.constants,
                transition_time=skill.transition_time,
                idle_time=skill.idle_time,
                episode_time=skill.episode_time,
            )
            cbdsl.learn_trials(request)
        if own == name:
            break
    return folder / _POLICIES / f"{name}.yaml"


def _file(folder: Path, skill: LearnedSkill) -> Path:
    return folder / "programs" / f"{skill.program}.yaml"


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each trial: whether most of its held-out episodes are rewarded."""
    skill = SKILLS[condition.name]
    for seed in seeds:
        policy = learned(condition.name, seed, body)
        folder = folder_of(seed, body.backend)
        request = cbdsl.load(_file(folder, skill), stage=skill.shown, policy=policy, folder=folder)
        rate = cbdsl.evaluate(
            request, seed=_HELD_OUT, episodes=_EPISODES, backend=body.backend, cameras=body.cameras
        )
        rewarded = [result.rewarded for result in rate.results]
        share = sum(rewarded) / len(rewarded)
        yield EpisodeVerdict(
            seed,
            {"learned": share >= _LEAST},
            sum(result.sim_seconds for result in rate.results),
            f"{sum(rewarded)} of {len(rewarded)} held-out episodes are rewarded",
            {"rewarded_percent": 100 * share},
        )


JUDGE = Judge(
    "five_skills",
    "the five skills of Chapter 4 from scratch, on held-out episodes",
    tuple(
        JudgedCondition(name, skill.program, {"learned": Aim(0.8)}, skill.shown)
        for name, skill in SKILLS.items()
    ),
    _measure,
    BodyChoice("kinematic", "ideal"),
    episodes=5,
)
