"""PICKANDPLACE assimilated: choice of hand and of hand-to-hand transfer (Figures 7.4 to 7.6).

Each trial continues a trial of Figure 7.3. Ten greedy episodes are followed by forty of ASSIMILATE,
in which the object and its goal may be far apart, and by held-out episodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl import Transition
from cbdsl.api.allocation import allocated
from cbdsl.api.documents import SchemaDocument, digest
from cbdsl.api.learning import ASSIMILATE, Accommodate, Assimilate, AssimilateConstants, Experience
from cbdsl.api.program import CheckedProgram, SchemaPolicy, state_values
from cbdsl.api.shipped import shipped_program
from cbdsl.api.trials import EPISODES, Journal, Trial, identity_of
from cbdsl_reproduction.chapter_4.learning_curves import per_transition
from cbdsl_reproduction.chapter_5.schema_trees import SchemaPicture
from cbdsl_reproduction.chapter_5.three_learners import dip_length
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import (
    TAIL,
    interquartile_interval,
    interquartile_mean,
    resampled_interval,
)
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, below
from cbdsl_reproduction.series import PICKANDPLACE, Series
from cbdsl_reproduction.trial_runner import LearnedTrial, TrialRunner, trial_runner

Floats = NDArray[np.float64]

_STAGE, _ACROSS = "things_and_far_pads", "across"
_LIMITS: dict[str, Any] = {"transition_time": 20.0, "idle_time": 1.0, "episode_time": 240.0}
# A failed transfer leaves the object on the other side, out of reach of the suitable hand. Many
# episodes therefore only show that the first attempt has failed.
_CONSTANTS = AssimilateConstants(blames_first=True)
# Episodes without exploration, with ASSIMILATE, and under its result, which the source lacks.
_GREEDY, _ASSIMILATING, _ASKED = 10, 40, 24
_QUICK = (2, 3, 2)
# Episodes on either side of the change of stages that measure the fall of the reward.
_AROUND = 5
# Least shares of chosen and of rewarded transfers if only a transfer can succeed, %.
_CHOSEN, _REWARDED = 90.0, 85.0

_DIPS = Claim(
    "Section 7.1.2, Figure 7.4",
    f"Figure 7.4: reward per transition in the {_AROUND} episodes after {{first}}, "
    "less that before",
    "",
    "a dip",
    below(0),
)
# The bound is the number of episodes of ASSIMILATE.
_RECOVERS = Claim(
    "Section 7.1.2, Figure 7.4",
    "Figure 7.4: length of the dip",
    "episodes",
    "about 20, and back by the end",
    bound=below,
)
_FAR = "Figures 7.5 and 7.6, held out, thing and goal far apart"
_CHOOSES, _TRANSFERS, _AT_ONCE = (
    Claim("Section 7.1.2, Figures 7.5 and 7.6", name, "%", "", above(least))
    for name, least in (
        (f"{_FAR}: a transfer from hand to hand is chosen", _CHOSEN),
        (f"{_FAR}: it is, and comes to the reward", _REWARDED),
        ("held out, both on one side: rewarded at once", _REWARDED),
    )
)
CLAIMS: Claims = {"fig-7.4-7.6": (_DIPS, _RECOVERS, _CHOOSES, _TRANSFERS, _AT_ONCE)}


class AssimilatedTrial(NamedTuple):
    """Trial from its beginning.

    Attributes:
        episodes: All training episodes, and the greedy ones in between.
        first: Number of episodes before ASSIMILATE.
        asked: Held-out episodes under the final schema.
        schema: Final schema.
    """

    episodes: tuple[Experience, ...]
    first: int
    asked: tuple[Experience, ...]
    schema: SchemaDocument


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials that the experiment continues."""
    return (PICKANDPLACE,)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> tuple[AssimilatedTrial, ...]:
    """Run all episodes."""
    parts = _QUICK if settings.quick else (_GREEDY, _ASSIMILATING, _ASKED)
    each = dexter.episodes(PICKANDPLACE) + sum(parts)
    dexter.expect(len(dexter.numbers(PICKANDPLACE)) * each)
    trials = _AssimilatedTrials(dexter, parts)
    return tuple(trials.go_on(learned) for learned in dexter.learn(PICKANDPLACE))


def run(settings: RunSettings, name: str) -> Result:
    """Learn in three stages, and evaluate the result."""
    with trial_runner(settings) as dexter:
        trials = gather(dexter, settings, name)
    chart = _chart(name, trials, settings.seed)
    picture = SchemaPicture(f"{name}-trees", "The trees of the first trial", trials[0].schema)
    return Result(tuple(quantities(trials, settings.seed)), (chart, picture), _NOTES)


_NOTES = (
    "Thirty episodes of ACCOMMODATE with the right arm, as in Figure 7.3, ten greedy ones, and "
    f"forty of ASSIMILATE on stage {_STAGE}: in a quarter of the episodes ball and goal are both "
    "on the right, in a quarter both on the left, in half the ball is far on the right and the "
    "goal far on the left, where neither hand reaches both. Each episode goes on with other "
    "allocations after one has failed, so that most are rewarded in the end, in more transitions.",
    "Allocations are all that the type table and the rewards admit: either arm, and for the left "
    "one, in place of the grasp, BIMANUALTOUCH and the handover, which both end with the thing "
    "touched by the left hand. BIMANUALTOUCH ends with both hands holding, and the transport then "
    "tears the thing out of one of them: the transfer that works here is the handover, which "
    "releases it.",
    "ASSIMILATE counts the first attempt of an episode without reward as failed: a failed "
    "transfer leaves the ball where the other hand does not reach it.",
    "The robot looks for the goal and for the object, and then chooses. These looks are no "
    "transitions of the program.",
)


class _AssimilatedTrials:
    """Continuation of learned trials; stored episodes are not run again.

    Args:
        dexter: Runner of the episodes.
        parts: Numbers of greedy, assimilating and held-out episodes.
    """

    def __init__(self, dexter: TrialRunner, parts: tuple[int, int, int]) -> None:
        self._dexter, self._parts = dexter, parts
        request = shipped_program(PICKANDPLACE.program, stage=_STAGE)
        self._program = allocated(request, PICKANDPLACE.program)
        self._stage = request.stage
        self._runner = dexter.episode_runner(self._stage)

    def go_on(self, learned: LearnedTrial) -> AssimilatedTrial:
        """Run the episodes that follow the episodes of ACCOMMODATE."""
        greedy, assimilating, asked = self._parts
        plain = self._dexter.greedy(learned, "greedy", learned.held_out(greedy))
        program = self._schema(learned)
        before = learned.trial
        trial = Trial(program, _CONSTANTS, before.seed, before.number, ASSIMILATE)

        def learn(seed: int) -> Experience:
            return trial.run(self._runner)

        # The trial draws its seeds itself.
        self._kept(learned, "assimilating", range(assimilating), learn, trial.replay)
        assert isinstance(trial.learner, Assimilate)
        schema = trial.learner.document(PICKANDPLACE.program, program)
        answered = self._asked(learned, program, trial.learner, asked)
        episodes = (*before.experiences, *plain, *trial.experiences)
        return AssimilatedTrial(episodes, len(episodes) - assimilating, answered, schema)

    def _schema(self, learned: LearnedTrial) -> CheckedProgram:
        """Return the program with all its allocations, under the policy of the trial."""
        learner, program = learned.trial.learner, self._program
        assert isinstance(learner, Accommodate)
        assert program.schema is not None
        actions = learner.greedy()
        worth = state_values(actions, dict(learner.counts.items())) if actions else {}
        schema = program.schema._replace(worth=worth)
        return program._replace(policy=actions, schema=schema, **_LIMITS)

    def _asked(
        self, learned: LearnedTrial, program: CheckedProgram, learner: Assimilate, count: int
    ) -> tuple[Experience, ...]:
        """Run episodes under the tree of allocations, without learning."""
        assert program.schema is not None
        schema = program.schema._replace(choice=learner.choice())
        known = program._replace(schema=schema)
        policy = SchemaPolicy(known, gives_up=False)
        # The greedy episodes have used the first held-out seeds.
        seeds = learned.held_out(self._parts[0] + count)[self._parts[0] :]

        def ask(seed: int) -> Experience:
            return self._runner.run(known, policy, seed, _ignore)

        return self._kept(learned, "asked", seeds, ask)

    def _kept(
        self,
        learned: LearnedTrial,
        name: str,
        seeds: Sequence[int],
        run_one: Callable[[int], Experience],
        replay: Callable[[Experience], None] = lambda experience: None,
    ) -> tuple[Experience, ...]:
        """Return the episodes stored beside the policy, and run the missing ones."""
        dexter, number = self._dexter, learned.trial.number
        path = learned.path.with_suffix(f".{name}.jsonl")
        with Journal(path, self._identity(learned), EPISODES) as journal:
            experiences = list(journal.rows[: len(seeds)])
            for experience in experiences:
                replay(experience)
            dexter.begin(number, dexter.renderer, experiences)
            for seed in seeds[len(experiences) :]:
                experiences.append(run_one(seed))
                journal.append(experiences[-1])
                dexter.note(number, experiences[-1])
        return tuple(experiences)

    def _identity(self, learned: LearnedTrial) -> Mapping[str, Any]:
        """Return all inputs of the episodes."""
        assert self._program.schema is not None
        return identity_of(learned.provenance) | {
            "policy": learned.trial.learner.greedy(),
            "allocations": {k: dict(v) for k, v in self._program.schema.allocations.items()},
            "far stage": digest(self._stage),
            "limits": _LIMITS,
            "constants": _CONSTANTS.model_dump(),
            "parts": list(self._parts[:2]),
        }


def quantities(trials: Sequence[AssimilatedTrial], seed: int) -> Iterator[Quantity]:
    """Yield the fall and recovery of the reward, and shares of chosen and rewarded transfers."""
    rewards, first = _rewards(trials), trials[0].first
    if _AROUND <= first <= rewards.shape[1] - _AROUND:
        before = rewards[:, first - _AROUND : first].mean(axis=1)
        after = rewards[:, first : first + _AROUND].mean(axis=1)
        yield mean_of(
            _DIPS.named(first=str(first)),
            (after - before).tolist(),
            seed=seed,
            note=f"{before.mean():.3f} before, {after.mean():.3f} after",
        )
    yield _recovery(rewards, first, seed)
    transfers = _transfers(trials[0].schema)
    far = [[each for each in trial.asked if each.context == _ACROSS] for trial in trials]
    near = [[each for each in trial.asked if each.context != _ACROSS] for trial in trials]

    def transferred(episode: Experience) -> bool:
        return _first_allocation(episode) in transfers

    def placed_so(episode: Experience) -> bool:
        return transferred(episode) and _earns_at_once(episode)

    for claim, episodes, holds in (
        (_CHOOSES, far, transferred),
        (_TRANSFERS, far, placed_so),
        (_AT_ONCE, near, _earns_at_once),
    ):
        # Episodes of one trial share its schema, so that each trial is one sample.
        shares = [100 * sum(map(holds, own)) / len(own) for own in episodes if own]
        note = f"mean over the trials; {sum(map(len, episodes))} episodes in all"
        if shares:
            yield mean_of(claim, shares, seed=seed, note=note)


def _rewards(trials: Sequence[AssimilatedTrial]) -> Floats:
    """Return the reward per transition, shape (trials, episodes)."""
    return np.array([[per_transition(each) for each in trial.episodes] for trial in trials])


def _recovery(rewards: Floats, first: int, seed: int) -> Quantity:
    """Return the number of episodes of ASSIMILATE until the mean curve recovers."""

    def length(some: Floats) -> float:
        return dip_length(some, first)

    interval = None
    if len(rewards) > 1:
        interval = resampled_interval(list(rewards), lambda drawn: length(np.array(drawn)), seed)
    left = rewards.shape[1] - first
    return Quantity(_RECOVERS.at(float(left)), length(rewards), interval, TAIL)


def _transfers(schema: SchemaDocument) -> set[str]:
    """Return the allocations that grasp with one hand and continue with the other."""
    own = {"arm", "hand"}
    # Other values than arm and hand name the program in the place
    # of the grasp. These two end with the object at the other hand.
    both = {"handover", "bimanualtouch"}
    return {
        name
        for name, values in schema.allocations.items()
        if both & {value for key, value in values.items() if key not in own}
    }


def _first_allocation(experience: Experience) -> str:
    return next((each.allocation for each in experience.transitions if each.allocation), "")


def _earns_at_once(experience: Experience) -> bool:
    """Return whether the episode was rewarded under the first allocation."""
    first = _first_allocation(experience)
    return any(each.reward and each.allocation == first for each in experience.transitions) and all(
        each.allocation in ("", first) for each in experience.transitions
    )


def _chart(name: str, trials: Sequence[AssimilatedTrial], seed: int) -> Chart:
    rewards = _rewards(trials)
    low, high = interquartile_interval(rewards, seed)
    episodes = tuple(map(float, range(1, rewards.shape[1] + 1)))
    middle = tuple(interquartile_mean(rewards).tolist())
    curve = Line("PICKANDPLACE", episodes, middle, tuple(low.tolist()), tuple(high.tolist()))
    first = trials[0].first
    return Chart(
        name,
        f"Reward per transition, {len(trials)} trials; ASSIMILATE from episode {first + 1} on",
        "episode",
        "reward per transition",
        (curve,),
    )


def _ignore(transition: Transition) -> None:
    """Ignore a transition: nothing is learned from held-out episodes."""
