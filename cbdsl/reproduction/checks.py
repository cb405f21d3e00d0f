"""Checks of what a trial has learned: its greedy policy, again and again, in held-out episodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cbdsl.learning.experience import Experience
from cbdsl.reproduction.experiment import RunSettings
from cbdsl.reproduction.series import Series
from cbdsl.reproduction.trial_runner import LearnedTrial, TrialRunner


@dataclass(frozen=True)
class Schedule:
    """When a trial is checked, and by how many episodes.

    Attributes:
        every: how many episodes lie between two checks.
        held_out: episodes of each check; the same ones each time.
    """

    every: int
    held_out: int

    def after(self, episodes: int) -> range:
        """The numbers of episodes after which there is a check."""
        return range(self.every, episodes + 1, self.every)


def schedule(settings: RunSettings) -> Schedule:
    """The usual schedule, or the quick one."""
    return Schedule(every=2, held_out=2) if settings.quick else Schedule(every=5, held_out=20)


@dataclass(frozen=True)
class Check:
    """The held-out episodes after some of a trial's own.

    Attributes:
        episodes: how many the policy was learned from.
        experiences: under the greedy policy.
    """

    episodes: int
    experiences: tuple[Experience, ...]

    def success(self, series: Series) -> float:
        """Share of the episodes that were rewarded, of those in which something can be."""
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
    """All checks of a trial, in their order; see ``TrialRunner.greedy`` for what is raised.

    Args:
        trial_runner: runs them.
        learned: the trial at its end.
        plan: how many episodes each has.
        when: after which of the trial's own episodes; ``None`` for the plan's.
    """
    passed: list[Check] = []
    for episodes in plan.after(len(learned.trial.experiences)) if when is None else when:
        known = [experience for each in passed for experience in each.experiences]
        passed.append(_check(runner, learned.after(episodes), plan, known))
    return tuple(passed)


def _check(
    runner: TrialRunner, learned: LearnedTrial, plan: Schedule, before: Sequence[Experience]
) -> Check:
    """Check what is known now, after checks of what was known before."""
    episodes = len(learned.trial.experiences)
    # Where it draws from what it learned, no two checks have the same program.
    known = () if learned.trial.learned_models() else before
    seeds = learned.held_out(plan.held_out)
    return Check(episodes, runner.greedy(learned, f"greedy_{episodes}", seeds, known=known))
