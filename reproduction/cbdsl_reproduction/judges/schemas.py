"""Schemas after some episodes of ASSIMILATE: required hands, and objects out of reach.

Correct answers come from held-out contexts in which every allocation is tried. The first choice of
a tree is right if it was rewarded. A schema that expects no reward is right if the object is out of
reach: no allocation is rewarded, and none touches the object, by the world's truth.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from cbdsl import Truth
from cbdsl.api.allocation import allocated
from cbdsl.api.control import Kinematics
from cbdsl.api.documents import StageDocument
from cbdsl.api.learning import ASSIMILATE, Assimilate, AssimilateConstants
from cbdsl.api.program import CheckedProgram, Features, Ranking, SchemaPolicy, decide
from cbdsl.api.sensing import EpisodeObserver, Tick
from cbdsl.api.shipped import shipped_document, shipped_program
from cbdsl.api.trials import BackendEpisodeRunner, Trial, embody_simulated
from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition

PROGRAM, _STAGE = "reachtouch", "near_and_far_training"
_EPISODES, _HELD_OUT = 50, range(8_400_000, 8_400_200)
# Least shares of right choices if several allocations work and if one does, and of objects out of
# reach that are reported so; largest share of objects in reach that are reported out of reach.
_POSSIBLE, _ALONE, _OUT_OF_REACH, _FALSE_ALARMS = 0.95, 0.9, 0.95, 0.02
_COUNTS = ("possible", "alone", "out_of_reach", "false_alarms", "touched_in_vain")


class Case(NamedTuple):
    """Held-out context: its features at the allocation, and its outcome.

    Attributes:
        features: Features as sensed.
        works: Allocations that were rewarded.
        is_touched: True if the robot touched the object with any allocation.
    """

    features: Features
    works: frozenset[str]
    is_touched: bool


class _TouchWatcher(EpisodeObserver):
    """Watcher of the robot's touches of shown objects.

    Without physics, the engine knows the touches of fingertips alone.

    Attributes:
        is_touched: True after a touch, until it is set to false.
    """

    def __init__(self, truth: Truth, stage: StageDocument) -> None:
        self._truth, self._stage = truth, stage
        self.is_touched = False

    def note_tick(self, tick: Tick) -> None:
        """Note the touches of a tick; see ``EpisodeObserver``."""
        shown = [name for name in self._truth.objects if name not in self._stage.fixtures]
        self.is_touched = self.is_touched or any(map(self._truth.is_touched, shown))


class Prepared(NamedTuple):
    """Program with all its allocations, its runner, and the watcher of its episodes."""

    program: CheckedProgram
    runner: BackendEpisodeRunner
    watcher: _TouchWatcher


def prepared(body: BodyChoice, stage: StageDocument) -> Prepared:
    """Return the program with all its allocations on a stage, ready to run."""
    at = shipped_program(PROGRAM, stage=_STAGE)
    program = allocated(at, PROGRAM)._replace(transition_time=8.0, idle_time=1.0)
    backend = embody_simulated(body.backend, at.robot, at.urdf, cameras=body.cameras)
    watcher = _TouchWatcher(Truth(backend.truth), stage)
    kinematics = Kinematics(at.robot, at.urdf)
    runner = BackendEpisodeRunner(at.robot, kinematics, backend, stage, watcher)
    return Prepared(program, runner, watcher)


def cases(at: Prepared, seeds: Iterable[int]) -> Iterator[tuple[int, Case]]:
    """Yield seeds and contexts with defined features, with every allocation tried in them."""
    program, runner, watcher = at
    assert program.schema is not None
    components = {*program.schema.components}
    policies = {
        name: SchemaPolicy(program, _always(name), gives_up=False)
        for name in program.schema.allocations
    }
    for seed in seeds:
        works, features = set(), dict[str, float]()
        watcher.is_touched = False
        for name, policy in policies.items():
            episode = runner.run(program, policy, seed, lambda transition: None)
            if episode.reward:
                works.add(name)
            for transition in episode.transitions:
                if not features and transition.features.keys() >= components:
                    features = dict(transition.features)
        if features:
            yield seed, Case(features, frozenset(works), watcher.is_touched)


@cache
def _prepared(body: BodyChoice) -> Prepared:
    return prepared(body, shipped_document(StageDocument, _STAGE))


@cache
def held_out(body: BodyChoice) -> tuple[Case, ...]:
    """Return the held-out contexts of all trials."""
    return tuple(case for _, case in cases(_prepared(body), _HELD_OUT))


def _always(name: str) -> Any:
    def rank(features: Features) -> Ranking:
        return (name,)

    return rank


def judged(learner: Assimilate, cases: Sequence[Case]) -> dict[str, list[int]]:
    """Return the numbers of right and of possible answers, by aim."""
    choice, reward = learner.choice(), learner.reward()
    counts = {name: [0, 0] for name in _COUNTS}
    for case in cases:
        gives_up = (decide(reward, case.features) or 0.0) < 0.5
        # A touched object was in reach, although no allocation was rewarded.
        # Neither answer is wrong then, so that such cases decide no aim.
        if not case.works:
            _count(counts["touched_in_vain" if case.is_touched else "out_of_reach"], gives_up)
            continue
        first = (decide(choice, case.features) or ("",))[0]
        _count(counts["false_alarms"], gives_up)
        _count(counts["possible"], first in case.works)
        if len(case.works) == 1:
            _count(counts["alone"], first in case.works)
    return counts


def _count(counts: list[int], is_so: bool) -> None:
    counts[0] += is_so
    counts[1] += 1


def holds(counts: Mapping[str, Sequence[int]]) -> bool:
    """Return whether a trial reaches all its aims."""
    # An aim without cases cannot be missed. Its share of 1 would miss the
    # largest share of false alarms, so that these have a check of their own.
    share = {aim: some / most if most else 1.0 for aim, (some, most) in counts.items()}
    return (
        share["possible"] >= _POSSIBLE
        and share["alone"] >= _ALONE
        and share["out_of_reach"] >= _OUT_OF_REACH
        and (not counts["false_alarms"][1] or share["false_alarms"] <= _FALSE_ALARMS)
    )


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each trial of learning, whose number is its seed."""
    program, runner, _ = _prepared(body)
    for seed in seeds:
        trial = Trial(program, AssimilateConstants(), seed, 0, ASSIMILATE)
        seconds = sum(trial.run(runner).sim_seconds for _ in range(_EPISODES))
        assert isinstance(trial.learner, Assimilate)
        counts = judged(trial.learner, held_out(body))
        measures = {f"{n}_percent": 100 * a / b for n, (a, b) in counts.items() if b}
        text = ", ".join(f"{name} {a} of {b}" for name, (a, b) in counts.items())
        yield EpisodeVerdict(seed, {"holds": holds(counts)}, seconds, text, measures)


JUDGE = Judge(
    "schemas",
    "schemas after 50 episodes, on 200 held-out contexts",
    (JudgedCondition("near and far", PROGRAM, {"holds": Aim(0.8)}, _STAGE),),
    _measure,
    BodyChoice("kinematic", "ideal"),
    episodes=10,
)
