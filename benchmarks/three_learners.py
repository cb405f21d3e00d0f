"""Three ways to learn REACHTOUCH with either hand and with both (Section 5.3.1, Figure 5.8).

Flat: Q-learning over all allocated actions, its state told apart by side and size of what is seen.
Concurrent: abstract actions by Q-learning, allocations by ASSIMILATE, both from zero. Staged: the
abstract actions with the right hand and small things on the right, then ASSIMILATE on everything.
What is out of reach is left out. Trials are kept in a folder, and not run again.

    python benchmarks/three_learners.py FOLDER --trials 20 --seed 1 [--episodes 200] [--staged 25]
        [--only staged] [--backend mujoco] [--cameras ideal] [--seconds 450]
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import embody
from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.accommodate import Accommodate
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.constants import AccommodateConstants
from cbdsl.learning.experience import Experience
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema_policy import Features, SchemaPolicy
from cbdsl.program.state_values import state_values
from cbdsl.program.transition import Transition
from cbdsl.reproduction.chart import Chart, Line
from cbdsl.reproduction.interval import interquartile_interval, interquartile_mean, over_trials
from cbdsl.reproduction.learning_curves import per_transition, settled_at
from cbdsl.sensing.kinematics import Kinematics
from cbdsl.training.episode_runner import BackendEpisodeRunner
from cbdsl.training.trial import used_programs
from cbdsl.types.policy import Policy
from cbdsl.yaml_text.library import Library

Floats = NDArray[np.float64]

LEARNERS = ("flat", "concurrent", "staged")
# What the flat learner takes for large; halfway, in size, between the largest small thing and the
# smallest large one of the stage.
LARGE = 0.012
# Episodes of a curve's end, by which it is normalised, with the share of greedy actions.
LAST, GREEDY = 50, 0.8
STAGE = "near_and_far_training"


class Situation(NamedTuple):
    """What the learners learn with.

    Attributes:
        schema: the program with all its allocations.
        own: the same with the right hand alone.
        everything: runs episodes with small things to the sides and large ones, in equal parts.
        right: runs episodes with small things on the right.
    """

    schema: CheckedProgram
    own: CheckedProgram
    everything: BackendEpisodeRunner
    right: BackendEpisodeRunner


def situation(options: argparse.Namespace) -> Situation:
    """Read and check what is needed, and make a body."""
    library = Library()
    policy = library.read(library.locate(PolicyDocument, "reachtouch"), PolicyDocument)
    path = library.locate(ProgramDocument, "reachtouch")
    limits: dict[str, Any] = {"transition_time": 8.0, "idle_time": 1.0}
    schema = program_to_assimilate(path, policy, Session(library), {})._replace(**limits)
    own = check_program(path, {}, library)._replace(**limits)
    robot_file = library.locate(RobotDocument, own.robot)
    robot = library.read(robot_file, RobotDocument).document
    urdf = robot_file.parent / robot.model
    kinematics = Kinematics(robot, urdf)
    body = embody(options.backend, robot, urdf, cameras=options.cameras)
    stage = library.read(library.locate(StageDocument, STAGE), StageDocument).document

    def runner(**shares: float) -> BackendEpisodeRunner:
        contexts = {
            name: stage.contexts[name].model_copy(update={"share": share})
            for name, share in shares.items()
        }
        shown = stage.model_copy(update={"contexts": contexts})
        return BackendEpisodeRunner(robot, kinematics, body, shown)

    return Situation(schema, own, runner(left=25, right=25, large=50), runner(right=1))


class FlatPolicy:
    """A policy whose states tell the side and size of what is seen, and what acts on it.

    Args:
        learner: chooses, and is taught.
        rng: of its exploration.
    """

    def __init__(self, learner: Accommodate, rng: np.random.Generator) -> None:
        self._learner, self._policy = learner, learner.policy(rng)
        self.reason, self.withdraws = "", False
        self.begin(dict)

    def begin(self, read: Callable[[], Features]) -> None:
        """See ``ContextPolicy.begin``."""
        self._read, self._state, self._acting = read, "", "-"

    def choose(self, state: str, *, changed: bool) -> str:
        """The next of all actions."""
        self._state = self._told(state)
        return self._policy.choose(self._state, changed=changed)

    def see(self, transition: Transition) -> None:
        """Teach one transition."""
        self._acting = transition.allocation[:1] or "-"
        after = self._told(transition.next_state)
        self._learner.see(replace(transition, state=self._state, next_state=after))

    def _told(self, state: str) -> str:
        features = self._read()
        side, size = features.get("place.y", math.nan), features.get("volume", math.nan)
        if math.isnan(side) or math.isnan(size):
            return f"{state}{self._acting}??"
        return f"{state}{self._acting}{'lr'[side < 0]}{'sL'[size > LARGE]}"


def flat(at: Situation, seeds: list[int], staged: int) -> Iterator[Experience]:
    """Episodes of the flat learner."""
    names = [action.name for action in at.schema.actions]
    learner = Accommodate(names, AccommodateConstants(), used_programs(at.schema))
    for seed in seeds:
        policy = FlatPolicy(learner, _rng(seed))
        yield at.everything.run(at.schema, policy, seed, policy.see)


def concurrent(at: Situation, seeds: list[int], staged: int) -> Iterator[Experience]:
    """Episodes of the concurrent learner."""
    learner = Accommodate(
        [a.name for a in at.own.actions], AccommodateConstants(), {0: "searchtrack"}
    )
    allocating = Assimilate(["searchtrack"], AssimilateConstants())
    abstract = {action.name: action.abstract for action in at.schema.actions}

    def see(transition: Transition) -> None:
        learner.see(replace(transition, action=abstract[transition.action]))

    for seed in seeds:
        known = _under(at.schema, learner)
        allocating.adopt(known)
        rng = _rng(seed)
        policy = _persistent(known, allocating, rng, learner.policy(rng))
        experience = at.everything.run(known, policy, seed, see)
        allocating.remember(experience)
        yield experience


def staged(at: Situation, seeds: list[int], staged: int) -> Iterator[Experience]:
    """Episodes of the staged learner."""
    learner = Accommodate(
        [a.name for a in at.own.actions], AccommodateConstants(), {0: "searchtrack"}
    )
    for seed in seeds[:staged]:
        yield at.right.run(at.own, learner.policy(_rng(seed)), seed, learner.see)
    known, allocating = (
        _under(at.schema, learner),
        Assimilate(["searchtrack"], AssimilateConstants()),
    )
    allocating.adopt(known)
    for seed in seeds[staged:]:
        policy = _persistent(known, allocating, _rng(seed), None)
        experience = at.everything.run(known, policy, seed, _ignore)
        allocating.remember(experience)
        yield experience


def _under(schema: CheckedProgram, learner: Accommodate) -> CheckedProgram:
    """A schema under what is known of its abstract actions."""
    assert schema.schema is not None
    greedy = learner.greedy()
    worth = state_values(greedy, dict(learner.counts.items())) if greedy else {}
    return schema._replace(policy=greedy, schema=schema.schema._replace(worth=worth))


def _persistent(
    program: CheckedProgram, learner: Assimilate, rng: np.random.Generator, choose: Policy | None
) -> SchemaPolicy:
    rank = learner.ranking(rng)
    return SchemaPolicy(program, rank, gives_up=False, declarative=choose, persists=True)


def _rng(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, 2])


def _ignore(transition: Transition) -> None:
    """ASSIMILATE learns from whole episodes."""


def curve(name: str, number: int, at: Situation, options: argparse.Namespace) -> list[float]:
    """Reward per transition of one trial, episode by episode; kept, and read if it is there."""
    kept = options.folder / f"{name}_{options.seed}_{number}.json"
    if kept.exists():
        known: list[float] = json.loads(kept.read_text())
        return known
    seeds = [
        int(np.random.SeedSequence([options.seed, number, k]).generate_state(1)[0])
        for k in range(options.episodes)
    ]
    learn = {"flat": flat, "concurrent": concurrent, "staged": staged}[name]
    rewards = [per_transition(each) for each in learn(at, seeds, options.staged)]
    kept.write_text(json.dumps([round(each, 6) for each in rewards]))
    return rewards


def summary(name: str, rewards: Floats, staged: int) -> dict[str, Any]:
    """What a learner's curves come to."""
    level = rewards[:, -LAST:].mean(axis=1)
    earning = level > 0.0  # what never earns anything has nothing to be normalised by
    normalised = GREEDY * rewards[earning].mean(axis=1) / level[earning]
    row = {
        "learner": name,
        "trials": len(rewards),
        "mean": _with_interval(rewards.mean(axis=1)),
        f"last_{LAST}": _with_interval(level),
        "normalised_mean": _with_interval(normalised) if len(normalised) else None,
        "earning": int(earning.sum()),
        "settled_at": settled_at(rewards),
    }
    if name == "staged":
        smooth = interquartile_mean(rewards)
        recovered = np.flatnonzero(
            np.convolve(smooth[staged:], np.full(5, 0.2), "valid")
            >= smooth[staged - 5 : staged].mean()
        )
        row["before_dip"] = round(float(smooth[staged - 5 : staged].mean()), 4)
        row["dip"] = round(float(smooth[staged : staged + 5].mean()), 4)
        row["dip_episodes"] = int(recovered[0]) if len(recovered) else None
    return row


def _with_interval(values: Floats) -> list[float]:
    low, high = over_trials(values) or (math.nan, math.nan)
    return [round(float(each), 4) for each in (interquartile_mean(values), low, high)]


def chart(curves: Mapping[str, Floats], normalised: bool) -> Chart:
    """The learning curves, smoothed over five episodes."""
    lines = []
    for name, rewards in curves.items():
        level = rewards[:, -LAST:].mean()
        scale = GREEDY / level if normalised and level else 1.0
        smooth = np.array([np.convolve(each, np.full(5, 0.2), "valid") for each in scale * rewards])
        low, high = interquartile_interval(smooth)
        x = tuple(float(k) for k in range(3, smooth.shape[1] + 3))
        lines.append(Line(name, x, tuple(interquartile_mean(smooth)), tuple(low), tuple(high)))
    return Chart(
        "three_learners",
        f"Reward per transition while learning, {len(next(iter(curves.values())))} trials",
        "episode",
        "normalised reward" if normalised else "reward per transition",
        tuple(lines),
    )


def main() -> None:
    """Learn what is not kept yet, and print what all trials come to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--staged", type=int, default=25)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=LEARNERS)
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no trial after that")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    began, at = time.perf_counter(), situation(options)
    names = LEARNERS if options.only is None else (options.only,)
    curves: dict[str, list[list[float]]] = {name: [] for name in names}
    for number in range(options.trials):
        if time.perf_counter() - began > options.seconds:
            break
        for name in names:
            curves[name].append(curve(name, number, at, options))
    whole = {name: np.array(some) for name, some in curves.items() if some}
    for name, rewards in whole.items():
        print(json.dumps(summary(name, rewards, options.staged)), flush=True)
    for normalised in (False, True):
        suffix = "_normalised" if normalised else ""
        picture = chart(whole, normalised).svg()
        (options.folder / f"three_learners{suffix}.svg").write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main()
