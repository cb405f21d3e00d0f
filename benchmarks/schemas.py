"""Quality of schemas after some episodes: required hands, and objects out of reach.

Each trial of ASSIMILATE starts from a learned policy with its own random numbers. Correct answers
come from held-out episodes, in which every allocation is tried; the rewarded ones are correct. The
first choice of a tree is correct if it is one of these. A schema that expects no reward is correct
if the object is out of reach: no allocation is rewarded, and the robot touches the object in none
of them, by the simulator's truth. Objects that are touched without a reward are counted separately,
without an aim. Held-out episodes may run on another backend than the learning. The exit status is 1
if too few trials reach their aims.

    python benchmarks/schemas.py --seed 1 [--episodes 50] [--trials 10] [--held-out 200]
        [--held-out-seed 8400000] [--json]
        [--program reachtouch] [--policy reachtouch] [--stage near_and_far_training]
        [--backend kinematic] [--cameras ideal] [--try-on bullet] [--try-with rendered]
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from contacts import shown

from cbdsl.backends.backend import Backend, embody
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.world_state import GroundTruthProvider
from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.learner import ASSIMILATE
from cbdsl.numeric.proportion import exact_interval
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema import Ranking
from cbdsl.program.schema_policy import Features, SchemaPolicy
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.tick import Tick
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.trial import Trial
from cbdsl.types.decision_tree import decide
from cbdsl.yaml_text.library import Library

# Least share of right choices where several allocations work and where one does, and of objects
# out of reach and reported so; largest share of objects in reach and reported out of reach.
POSSIBLE, ALONE, OUT_OF_REACH, FALSE_ALARMS = 0.95, 0.9, 0.95, 0.02
# Share of the trials that have to reach their aims.
LEAST_SHARE = 0.8
#: Counts of a trial, with an aim each but for the last.
COUNTS = ("possible", "alone", "out_of_reach", "false_alarms", "touched_in_vain")


class Case(NamedTuple):
    """Held-out context: its features at the allocation, and its outcome.

    Attributes:
        context: Name of the context.
        features: Features as sensed.
        works: Allocations that were rewarded.
        touched: True if the robot touched the object with any allocation.
    """

    context: str
    features: Features
    works: frozenset[str]
    touched: bool


class TouchWatcher(EpisodeObserver):
    """Watcher of the robot's touches of shown objects, by the simulator's truth.

    For bodies without physics it knows the touches of fingertips alone.

    Attributes:
        touched: True if it did, since this was set to false.
    """

    def __init__(self, backend: Backend, stage: StageDocument) -> None:
        assert isinstance(backend, GroundTruthProvider)
        assert isinstance(backend.truth, Engine)
        self._truth, self._stage = backend.truth, stage
        self.touched = False

    def note_tick(self, tick: Tick) -> None:
        """Note the touches of a tick; see ``EpisodeObserver``."""
        truth = self._truth
        self.touched = self.touched or any(map(truth.touched, shown(truth, self._stage)))


def prepared(
    options: argparse.Namespace, backend: str, cameras: str | None
) -> tuple[CheckedProgram, BackendEpisodeRunner, TouchWatcher]:
    """Return the program with all its allocations, its runner on a backend, and its watcher."""
    library = Library()
    policy = library.read(library.locate(PolicyDocument, options.policy), PolicyDocument)
    path = library.locate(ProgramDocument, options.program)
    program = program_to_assimilate(path, policy, Session(library), {})
    robot_file = library.locate(RobotDocument, program.robot)
    robot = library.read(robot_file, RobotDocument).document
    stage = library.read(library.locate(StageDocument, options.stage), StageDocument).document
    urdf = robot_file.parent / robot.model
    body = embody(backend, robot, urdf, cameras=cameras)
    watcher = TouchWatcher(body, stage)
    runner = BackendEpisodeRunner(robot, Kinematics(robot, urdf), body, stage, watcher)
    return program._replace(transition_time=8.0, idle_time=1.0), runner, watcher


def cases(
    program: CheckedProgram,
    runner: BackendEpisodeRunner,
    watcher: TouchWatcher,
    seeds: Sequence[int],
) -> Iterator[Case]:
    """Yield held-out contexts in which the features were defined, by trying every allocation."""
    assert program.schema is not None
    names, components = tuple(program.schema.allocations), program.schema.components
    policies = {name: SchemaPolicy(program, _always(name), gives_up=False) for name in names}
    for seed in seeds:
        works, context, features = set(), "", dict[str, float]()
        watcher.touched = False
        for name, policy in policies.items():
            episode = runner.run(program, policy, seed, lambda transition: None)
            context = episode.context
            if episode.reward:
                works.add(name)
            for transition in episode.transitions:
                if not features and transition.features.keys() >= set(components):
                    features = dict(transition.features)
        if features:
            yield Case(context, features, frozenset(works), watcher.touched)


def _always(name: str) -> Any:
    def rank(features: Features) -> Ranking:
        return (name,)

    return rank


def learned(
    program: CheckedProgram, runner: BackendEpisodeRunner, number: int, options: argparse.Namespace
) -> Assimilate:
    """Return the learner after a trial."""
    trial = Trial(program, AssimilateConstants(), options.seed, number, ASSIMILATE)
    for _ in range(options.episodes):
        trial.run(runner)
    assert isinstance(trial.learner, Assimilate)
    return trial.learner


def judged(learner: Assimilate, held_out: Sequence[Case]) -> dict[str, list[int]]:
    """Return counts of right and of possible answers, by aim."""
    choice, reward = learner.choice(), learner.reward()
    counts = {name: [0, 0] for name in COUNTS}
    for case in held_out:
        said = (decide(reward, case.features) or 0.0) < 0.5
        if not case.works:
            _count(counts["touched_in_vain" if case.touched else "out_of_reach"], said)
            continue
        first = (decide(choice, case.features) or ("",))[0]
        _count(counts["false_alarms"], said)
        _count(counts["possible"], first in case.works)
        if len(case.works) == 1:
            _count(counts["alone"], first in case.works)
    return counts


def _count(counts: list[int], is_so: bool) -> None:
    counts[0] += is_so
    counts[1] += 1


def holds(counts: Mapping[str, Sequence[int]]) -> bool:
    """Return True if a trial reaches all its aims."""
    share = {aim: some / most if most else 1.0 for aim, (some, most) in counts.items()}
    return (
        share["possible"] >= POSSIBLE
        and share["alone"] >= ALONE
        and share["out_of_reach"] >= OUT_OF_REACH
        and (not counts["false_alarms"][1] or share["false_alarms"] <= FALSE_ALARMS)
    )


def main() -> int:
    """Learn, try, and print; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=50)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--held-out", type=int, default=200)
    parser.add_argument("--held-out-seed", type=int, default=8_400_000)
    parser.add_argument("--program", default="reachtouch")
    parser.add_argument("--policy", default="reachtouch")
    parser.add_argument("--stage", default="near_and_far_training")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    parser.add_argument("--try-on", metavar="BACKEND", help="for held-out episodes")
    parser.add_argument("--try-with", choices=("rendered", "ideal"), help="their cameras")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    began = time.perf_counter()
    program, runner, _ = prepared(options, options.backend, options.cameras)
    if options.try_on is None:
        options.try_on, options.try_with = options.backend, options.cameras
    _, judge, watcher = prepared(options, options.try_on, options.try_with)
    seeds = range(options.held_out_seed, options.held_out_seed + options.held_out)
    held_out = list(cases(program, judge, watcher, seeds))
    _show({"held_out": len(held_out), "seconds": round(time.perf_counter() - began)}, options)
    met, total = 0, {name: [0, 0] for name in COUNTS}
    for number in range(options.trials):
        counts = judged(learned(program, runner, number, options), held_out)
        met += holds(counts)
        for aim, (some, most) in counts.items():
            total[aim] = [total[aim][0] + some, total[aim][1] + most]
        _show({"trial": number, **counts, "holds": holds(counts)}, options)
    shares = {aim: _share(*counts) for aim, counts in total.items()}
    seconds = round(time.perf_counter() - began)
    _show({"trials": options.trials, "hold": met, **shares, "seconds": seconds}, options)
    return 0 if met >= LEAST_SHARE * options.trials else 1


def _share(some: int, most: int) -> list[float]:
    """Return the share with its 95 % interval, empty for a count of zero."""
    if not most:
        return []
    low, high = exact_interval(some, most)
    return [round(some / most, 3), round(low, 3), round(high, 3)]


def _show(row: Mapping[str, Any], options: argparse.Namespace) -> None:
    words = (f"{key} {value}" for key, value in row.items())
    print(json.dumps(row) if options.json else "  ".join(words), flush=True)


if __name__ == "__main__":
    sys.exit(main())
