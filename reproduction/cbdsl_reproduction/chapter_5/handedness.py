"""Handedness: REACHTOUCH with either arm and with both, learned in three ways (Section 5.3.1)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from cbdsl import Transition
from cbdsl.api.allocation import allocated, allocations
from cbdsl.api.documents import StageDocument, digest
from cbdsl.api.learning import AccommodateConstants, AssimilateConstants, Experience
from cbdsl.api.program import (
    NO_FEATURES,
    CheckedProgram,
    Choice,
    Features,
    Policy,
    Predicate,
    Ranking,
    SchemaPolicy,
)
from cbdsl.api.shipped import shipped_program
from cbdsl.api.trials import EPISODES, Journal, trial_journal, versions
from cbdsl_reproduction.chapter_5.side_by_side import side_by_side
from cbdsl_reproduction.handedness_series import FLAT, STAGED, HandednessSeries
from cbdsl_reproduction.learners.concurrent import Concurrent
from cbdsl_reproduction.learners.context_letters import LETTERS, context_letters
from cbdsl_reproduction.learners.flat import Flat, FlatPolicy
from cbdsl_reproduction.learners.handedness_learner import HandednessLearner, replay
from cbdsl_reproduction.learners.staged import Staged
from cbdsl_reproduction.source_features import with_source_features
from cbdsl_reproduction.trial_runner import TrialRunner

_PROGRAM, _STAGE, _OWN = "reachtouch", "handedness_training", "right"
# Half as many transitions as the source has, so that a hundred trials take an hour.
_LIMITS: dict[str, Any] = {"transitions": 50, "transition_time": 8.0, "idle_time": 0.5}
_EXPLORATION = 2
# The source's epsilon-greedy choice of allocations, instead of ours.
_ALLOCATING = AssimilateConstants(draws=False)
# First number of the episodes that measure the best policies.
_OPTIMUM = 2_000_000
# A search provides the features one transition earlier than a reach.
_START, _LOOK = "XXX", "searchtrack"
_BOTH, _LEFT, _RIGHT = "reachtouch_bimanual", "left_arm", "right_arm"


class Situation(NamedTuple):
    """Programs and stages of the learners.

    Attributes:
        schema: Program with all its allocations.
        own: Program with the right arm alone.
        flat: Program with all allocations side by side.
        everything: Stage with small objects on both sides, still or moving, and large ones.
        right: Stage with small objects on the right that keep still.
    """

    schema: CheckedProgram
    own: CheckedProgram
    flat: CheckedProgram
    everything: StageDocument
    right: StageDocument


def situation() -> Situation:
    """Read and check the shipped documents."""
    request = shipped_program(_PROGRAM, stage=_STAGE)
    own = request.program._replace(**_LIMITS)
    schema = with_source_features(allocated(request, _PROGRAM))._replace(**_LIMITS)
    assert schema.schema is not None
    variants = {name: variant._replace(**_LIMITS) for name, variant in allocations(request).items()}
    flat = side_by_side(variants, schema.schema)
    stage = request.stage
    right = stage.model_copy(update={"contexts": {_OWN: stage.contexts[_OWN]}})
    return Situation(schema, own, flat, stage, right)


class HandednessTrials:
    """Trials of the three learners and of the best policies, stored episode by episode.

    Args:
        dexter: Runner of the episodes.
        seed: Seed of all random numbers.
    """

    def __init__(self, dexter: TrialRunner, seed: int) -> None:
        self._dexter, self._seed = dexter, seed
        self._at = situation()
        self._everything = dexter.episode_runner(self._at.everything)
        self._right = dexter.episode_runner(self._at.right)

    @property
    def own(self) -> CheckedProgram:
        """Program with its own arm."""
        return self._at.own

    def learner(self, series: HandednessSeries) -> HandednessLearner:
        """Return a learner without experience."""
        at, constants = self._at, AccommodateConstants()
        if series == FLAT:
            return Flat(at.flat, constants)
        if series == STAGED:
            return Staged(at.schema, at.own, constants, _ALLOCATING, self.constrained(series))
        exploring = self.exploring(series)
        own = constants.model_copy(update={"exploring_episodes": exploring})
        return Concurrent(at.schema, own, _ALLOCATING)

    def constrained(self, series: HandednessSeries) -> int:
        """Return the number of episodes of the first stage, at most a third of all."""
        return self._at_most_a_third(series.constrained, series)

    def exploring(self, series: HandednessSeries) -> int | None:
        """Return the number of episodes that explore actions, at most a third; ``None`` for all."""
        if series.exploring is None:
            return None
        return self._at_most_a_third(series.exploring, series)

    def _at_most_a_third(self, count: int, series: HandednessSeries) -> int:
        # A quick run has fewer episodes than the first
        # stage of a full one, and still needs both stages.
        return min(count, self._dexter.episodes(series) // 3)

    def learn(self, series: HandednessSeries, number: int) -> tuple[Experience, ...]:
        """Return all episodes of one trial; stored episodes are not run again.

        Raises:
            JournalError: The stored episodes belong to another trial.
            BackendError, EpisodeError, OSError: As ``TrialRunner.learn``.
        """
        dexter, learner = self._dexter, self.learner(series)
        count = dexter.episodes(series)
        path = trial_journal(dexter.path(series, number))
        with Journal(path, self._identity(series, number), EPISODES) as journal:
            experiences = list(journal.rows[:count])
            for experience in experiences:
                replay(learner, experience)
            dexter.begin(number, dexter.renderer, experiences)
            while len(experiences) < count:
                experiences.append(self._run(learner, self._episode_seed(number, len(experiences))))
                journal.append(experiences[-1])
                dexter.note(number, experiences[-1])
        return tuple(experiences)

    def optimum(self, series: HandednessSeries, count: int) -> list[Experience]:
        """Return episodes under the best policy of a learner's actions, which follows Figure 5.10.

        Raises:
            JournalError, BackendError, EpisodeError, OSError: As ``learn``.
        """
        program, policy = self._best(series)
        path = trial_journal(self._dexter.path(series, _OPTIMUM))
        with Journal(path, self._identity(series, _OPTIMUM), EPISODES) as journal:
            experiences = list(journal.rows[:count])
            while len(experiences) < count:
                seed = self._episode_seed(_OPTIMUM, len(experiences))
                experiences.append(self._everything.run(program, policy, seed, _ignore))
                journal.append(experiences[-1])
        return experiences

    def _best(self, series: HandednessSeries) -> tuple[CheckedProgram, Policy]:
        at = self._at
        if series == FLAT:
            return at.flat, _flat_optimum(at.flat)
        program = at.schema._replace(policy=dict(at.own.policy) | {_START: _LOOK})
        return program, SchemaPolicy(program, _by_figure, gives_up=False, persists=True)

    def _run(self, learner: HandednessLearner, seed: int) -> Experience:
        episode_runner = self._right if learner.is_constrained else self._everything
        learner.begin()
        program, policy = learner.plan(np.random.default_rng([seed, _EXPLORATION]))
        experience = episode_runner.run(program, policy, seed, learner.see)
        learner.remember(experience)
        return experience

    def _episode_seed(self, number: int, episode: int) -> int:
        # The sequence mixes its numbers, so that adjacent trials and episodes have unrelated seeds.
        entropy = np.random.SeedSequence([self._seed, number, episode])
        return int(entropy.generate_state(1)[0])

    def _identity(self, series: HandednessSeries, number: int) -> dict[str, Any]:
        """Return all inputs of the episodes of a trial."""
        dexter = self._dexter
        program = shipped_program(_PROGRAM).digest
        exploring = self.exploring(series)
        return {
            "learner": series.name,
            # Trials stored without this number explore actions until their end.
            **({} if exploring is None else {"exploring": exploring}),
            "constrained": self.constrained(series),
            "seed": self._seed,
            "number": number,
            "program": program.sha256,
            "policies": dict(program.policies),
            "limits": _LIMITS,
            # Trials stored without this constant are identical to trials with its default.
            "allocating": _ALLOCATING.model_dump(exclude={"blames_first"}),
            "stage": digest(self._at.everything),
            "robot": digest(dexter.robot),
            "renderer": dexter.renderer,
            "versions": versions(),
        }


def _by_figure(features: Mapping[str, float]) -> Ranking:
    """Rank arms as in Figure 5.10: both if large, else by direction of motion or by side."""
    return _arms(context_letters(features))


def _arms(letters: str) -> Ranking:
    # A moving object is met by the arm of the side that
    # it moves to, even if it is on the other side.
    motion, side, scale = tuple(letters)
    first = _BOTH if scale == "L" else _LEFT if (motion if motion != "s" else side) == "l" else ""
    return tuple(dict.fromkeys((first or _RIGHT, _RIGHT, _LEFT, _BOTH)))


def _flat_optimum(program: CheckedProgram) -> Policy:
    """Return the policy that searches, reaches and touches with the arm of Figure 5.10."""

    class Best(Policy):
        def choose(self, state: str, *, changed: bool, features: Features = NO_FEATURES) -> Choice:
            predicates = dict(zip(program.members, state[:-LETTERS], strict=True))
            letters, search = state[-LETTERS:], program.members[0]
            if predicates[search] == Predicate.TRANSIENT or "?" in letters:
                return Choice(search)
            arm = _arms(letters)[0]
            has_arrived = predicates[f"reach({arm})"] == Predicate.QUIESCENT
            # A touch goes on as long as it changes the state; after a failed one, the arm reaches
            # again.
            touches = changed and predicates[f"touch({arm})"] != Predicate.INACTIVE
            return Choice(f"touch({arm})" if has_arrived or touches else f"reach({arm})")

    return FlatPolicy(Best())


def _ignore(transition: Transition) -> None:
    """Ignore a transition: the best policies learn nothing."""
