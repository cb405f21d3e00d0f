"""Checks of a trial: repeated runs of its greedy policy in held-out episodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cbdsl.api.learning import Experience
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.series import Series
from cbdsl_reproduction.trial_runner import LearnedTrial, TrialRunner


@dataclass(frozen=True)
class Schedule:
    """Schedule of the checks of a trial.

    Attributes:
        every: Number of episodes between two checks.
        held_out: Number of episodes of each check; all checks use the same ones.
    """

    every: int
    held_out: int

    def after(self, episodes: int) -> range:
        """Return the numbers of episodes after which to check."""
        return range(self.every, episodes + 1, self.every)


def schedule(settings: RunSettings) -> Schedule:
    """Return the usual schedule, or the quick one."""
    return Schedule(every=2, held_out=2) if settings.quick else Schedule(every=5, held_out=20)


@dataclass(frozen=True)
class Check:
    """Held-out episodes after some of a trial's own episodes.

    Attributes:
        episodes: Number of episodes from which the policy was learned.
        experiences: Held-out episodes under the greedy policy.
    """

    episodes: int
    experiences: tuple[Experience, ...]

    def success(self, series: Series) -> float:
        """Return the share of rewarded episodes among the episodes with a possible reward."""
        rewarded = [
            each.reward > 0 for each in self.experiences if each.context not in series.hopeless
        ]
        return sum(rewarded) / len(rewarded) if rewarded else 0.0


def checks(
    runner: TrialRunner,
    learned: LearnedTrial,
    plan: Schedule,
    when: Sequence[int] | None = None,
) -> tuple[Check, ...]:
    """Return all checks of a trial, in order; see ``TrialRunner.greedy`` for the exceptions.

    Args:
        runner: Runner of the episodes.
        learned: Trial at its end.
        plan: Schedule of the checks.
        when: Numbers of episodes after which to check; ``None`` for the numbers of the plan.
    """
    passed: list[Check] = []
    for episodes in plan.after(len(learned.trial.experiences)) if when is None else when:
        known = [experience for each in passed for experience in each.experiences]
        passed.append(_check(runner, learned.after(episodes), plan, known))
    return tuple(passed)


def _check(
    runner: TrialRunner, learned: LearnedTrial, plan: Schedule, before: Sequence[Experience]
) -> Check:
    """Check the current policy, reusing episodes of earlier checks."""
    episodes = len(learned.trial.experiences)
    # If it draws from learned models, no two checks have the same program.
    known = () if learned.trial.learned_models() else before
    seeds = learned.held_out(plan.held_out)
    return Check(episodes, runner.greedy(learned, f"greedy_{episodes}", seeds, known=known))
