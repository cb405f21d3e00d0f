"""Three learners of handedness, their settling times and retries (Figures 5.8 and 5.9)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.learning import Experience
from cbdsl_reproduction.chapter_4.learning_curves import per_transition
from cbdsl_reproduction.chapter_5.handedness import HandednessTrials
from cbdsl_reproduction.chapter_5.retries import RETRY_CLAIMS, retry_diagram, retry_quantities
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.handedness_series import (
    BRIEF,
    CONCURRENT,
    FLAT,
    STAGED,
    HandednessSeries,
)
from cbdsl_reproduction.interval import TAIL, resampled_interval
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, below, near
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

Floats = NDArray[np.float64]
Statistic = Callable[[Floats], float]

# Final episodes that define a learner's level, and episodes evaluated around the change of stages.
_LAST, _AROUND = 50, 5
# Final level of the source's learners, which follows from their epsilon.
_LEVEL = 0.8
# Share of a level that counts as near it.
_NEAR = 0.8
# Episodes under the best policies.
_BEST, _QUICK_BEST = 60, 4
# Half of the width of a 95 % interval, in standard errors.
_NORMAL = 1.96

_PLACE = "Section 5.3.1.2, Figure 5.8"
_AHEAD = Claim(
    _PLACE,
    "normalised reward over all episodes, {one} minus {other}",
    "",
    "above 0",
    above(0),
)
_SETTLES = {
    series: Claim(
        _PLACE,
        f"{series.label}: episodes until the curve stays at the common level",
        "episodes",
        report,
        region,
    )
    for series, report, region in (
        (FLAT, "about 140", near(140, 40)),
        (CONCURRENT, "about 50", near(50, 20)),
        (STAGED, "ahead of the others", below(50)),
    )
}
_ENDS = {
    series: Claim(
        _PLACE,
        f"{series.label}: normalised reward in the last {_LAST} episodes",
        "",
        f"{_LEVEL}",
        near(_LEVEL, 0.1),
    )
    for series in (FLAT, CONCURRENT, STAGED)
}
_DROPS = Claim(
    _PLACE,
    f"staged: normalised reward in the {_AROUND} episodes after {{first}}, less that before",
    "",
    "a sharp drop",
    below(0),
)
_RECOVERS = Claim(_PLACE, "staged: length of the drop", "episodes", "about 10", near(10, 5))
CLAIMS: Claims = {
    "fig-5.8": (
        _AHEAD.named(one=STAGED.label, other=BRIEF.label),
        _AHEAD.named(one=STAGED.label, other=CONCURRENT.label),
        _AHEAD.named(one=CONCURRENT.label, other=FLAT.label),
        *_SETTLES.values(),
        *_ENDS.values(),
        _DROPS,
        _RECOVERS,
    ),
    "fig-5.9": RETRY_CLAIMS,
}


@dataclass(frozen=True)
class LearnerTrials:
    """Trials of one learner.

    Attributes:
        series: Series of the learner.
        trials: Episodes of each trial.
        best: Reward per transition under the best policy of the same actions.
        constrained: Number of episodes of a first stage.
    """

    series: HandednessSeries
    trials: tuple[tuple[Experience, ...], ...]
    best: float
    constrained: int = 0

    @property
    def raw(self) -> Floats:
        """Reward per transition, shape (trials, episodes)."""
        return np.array([[per_transition(each) for each in trial] for trial in self.trials])

    @property
    def rewards(self) -> Floats:
        """Rewards relative to the best policy; NaN if that earns nothing."""
        # Flat and abstract actions differ in the largest possible reward.
        # Relative to that, the curves compare the learners alone.
        return self.raw / self.best if self.best else self.raw * math.nan


def series_of(name: str) -> tuple[HandednessSeries, ...]:
    """Return the series of trials."""
    return (STAGED,) if name == "fig-5.9" else (FLAT, CONCURRENT, BRIEF, STAGED)


def gather(
    dexter: TrialRunner, settings: RunSettings, name: str
) -> dict[HandednessSeries, tuple[tuple[Experience, ...], ...]]:
    """Run all episodes, by learner and trial."""
    for series in series_of(name):
        dexter.expect(len(dexter.numbers(series)) * dexter.episodes(series))
    trials = HandednessTrials(dexter, settings.seed)
    return {
        series: tuple(trials.learn(series, number) for number in dexter.numbers(series))
        for series in series_of(name)
    }


def run(settings: RunSettings, name: str) -> Result:
    """Learn, and compare the rewards during learning."""
    with trial_runner(settings) as dexter:
        learned, trials = gather(dexter, settings, name), HandednessTrials(dexter, settings.seed)
        if name == "fig-5.9":
            assimilated = [trial[trials.constrained(STAGED) :] for trial in learned[STAGED]]
            quantities = tuple(retry_quantities(assimilated))
            diagram = retry_diagram(name, trials.own, assimilated)
            return Result(quantities, (diagram,), _RETRY_NOTES)
        count = _QUICK_BEST if settings.quick else _BEST
        bests = {series: trials.optimum(series, count) for series in (FLAT, CONCURRENT)}
    earned = {
        series: np.array([per_transition(each) for each in best]) for series, best in bests.items()
    }
    # The staged learner has the abstract actions of the concurrent one, and therefore its best
    # policy.
    groups = [
        LearnerTrials(
            series,
            episodes,
            float(earned[FLAT if series == FLAT else CONCURRENT].mean()),
            trials.constrained(series),
        )
        for series, episodes in learned.items()
    ]
    charts = tuple(_chart(name, groups, normalised) for normalised in (False, True))
    return Result(tuple(quantities_of(groups, settings.seed)), charts, _notes(earned, count))


def quantities_of(groups: Sequence[LearnerTrials], seed: int) -> Iterator[Quantity]:
    """Yield the order of the learners, their settling times, and the dip of the staged one."""
    flat, concurrent, brief, staged = groups
    yield _ahead(staged, brief, seed)
    yield _ahead(staged, concurrent, seed)
    yield _ahead(concurrent, flat, seed)
    for group in (flat, concurrent, staged):
        yield _of_curves(_SETTLES[group.series], group.rewards, stable_at, seed)
    for group in (flat, concurrent, staged):
        yield mean_of(
            _ENDS[group.series],
            group.rewards[:, -_LAST:].mean(axis=1).tolist(),
            seed=seed,
            note=f"raw {group.raw[:, -_LAST:].mean():.4f}, best {group.best:.4f}",
        )
    yield from dip_quantities(staged, seed)


def _ahead(one: LearnerTrials, other: LearnerTrials, seed: int) -> Quantity:
    """Return the additional normalised reward of one learner over another in all episodes."""
    # Trials of one number share the seeds of their
    # episodes, so that their difference is one sample.
    means = [group.rewards.mean(axis=1) for group in (one, other)]
    names = [group.series.label for group in (one, other)]
    raw = [group.raw.mean() for group in (one, other)]
    apart = " and ".join(_with_interval(n, m) for n, m in zip(names, means, strict=True))
    return mean_of(
        _AHEAD.named(one=names[0], other=names[1]),
        (means[0] - means[1]).tolist(),
        seed=seed,
        note=f"{apart}; raw {raw[0]:.4f} and {raw[1]:.4f}",
    )


def _with_interval(name: str, values: Floats) -> str:
    half = _half_width(values)
    return f"{name} {values.mean():.3f} ± {half:.3f}"


def _half_width(values: Floats) -> Floats:
    """Return half of the width of the mean's 95 % interval along the first axis."""
    if len(values) < 2:
        return np.zeros(values.shape[1:])
    half: Floats = _NORMAL * values.std(axis=0, ddof=1) / math.sqrt(len(values))
    return half


def stable_at(rewards: Floats) -> float:
    """Return the episode from which the mean curve stays near the common level.

    Args:
        rewards: Normalised rewards, shape (trials, episodes).

    Returns:
        Episode number; larger than the number of episodes if the curve never settles.
    """
    # Single episodes are rewarded or not, so that even the mean of all trials
    # leaves a level now and then. Five episodes are averaged, as for the drop.
    smooth = np.convolve(rewards.mean(axis=0), np.full(_AROUND, 1 / _AROUND), mode="valid")
    low = np.flatnonzero(smooth < _NEAR * _LEVEL)
    if not len(low):
        return 1.0
    # A curve that is low at its end has not settled within the trial.
    is_last = low[-1] == len(smooth) - 1
    return rewards.shape[1] + 1.0 if is_last else float(low[-1]) + 2


def dip_quantities(staged: LearnerTrials, seed: int) -> Iterator[Quantity]:
    """Yield the depth and length of the staged learner's dip when the second stage begins."""
    first = staged.constrained
    if not _AROUND <= first <= staged.raw.shape[1] - _AROUND:  # there is no second stage
        return
    rewards = staged.rewards
    before = rewards[:, first - _AROUND : first].mean(axis=1)
    after = rewards[:, first : first + _AROUND].mean(axis=1)
    yield mean_of(
        _DROPS.named(first=str(first)),
        (after - before).tolist(),
        seed=seed,
        note=f"{before.mean():.3f} before, {after.mean():.3f} after",
    )
    yield _of_curves(_RECOVERS, rewards, lambda some: dip_length(some, first), seed)


def dip_length(rewards: Floats, first: int) -> float:
    """Return the number of episodes of the second stage until the mean curve recovers.

    Args:
        rewards: Rewards, shape (trials, episodes).
        first: Number of episodes of the first stage.

    Returns:
        Number of episodes; all of the second stage if the curve never recovers.
    """
    curve = rewards.mean(axis=0)
    # The level is that of the end of the first stage. The second stage has
    # other objects, so that its final level is no measure of a recovery.
    level = _NEAR * curve[first - _AROUND : first].mean()
    smooth = np.convolve(curve[first:], np.full(_AROUND, 1 / _AROUND), mode="valid")
    # The index of the first window that recovers is the number of episodes before that window.
    back = np.flatnonzero(smooth >= level)
    return float(back[0]) if len(back) else float(len(curve) - first)


def _of_curves(claim: Claim, rewards: Floats, statistic: Statistic, seed: int) -> Quantity:
    """Return a number of episodes as a statistic of the curve of all trials."""
    value = statistic(rewards)
    interval = None
    if len(rewards) > 1:
        interval = resampled_interval(list(rewards), lambda drawn: statistic(np.array(drawn)), seed)
    # The time at which a curve crosses a level does not shift with its
    # samples, so that the double bootstrap of ``estimate`` does not apply.
    # The chance is the tail of the interval beyond one end instead.
    reached = value if value <= rewards.shape[1] else math.nan
    return Quantity(claim, reached, interval, TAIL)


def _chart(name: str, groups: Sequence[LearnerTrials], normalised: bool) -> Chart:
    kind = "normalised reward per transition" if normalised else "reward per transition"
    return Chart(
        f"{name}-{'normalised' if normalised else 'raw'}",
        f"While learning, {len(groups[0].trials)} trials, means of {_AROUND} episodes",
        "episode",
        kind,
        tuple(_line(group.series.label, _of(group, normalised)) for group in groups),
    )


def _of(group: LearnerTrials, normalised: bool) -> Floats:
    return group.rewards if normalised else group.raw


def _line(label: str, rewards: Floats) -> Line:
    kernel = np.full(_AROUND, 1 / _AROUND)
    smooth = np.array([np.convolve(each, kernel, mode="valid") for each in rewards])
    middle, half = smooth.mean(axis=0), _half_width(smooth)
    x = np.arange(smooth.shape[1]) + (_AROUND + 1) / 2
    columns = (x, middle, middle - half, middle + half)
    return Line(label, *(tuple(each.tolist()) for each in columns))


def _notes(earned: Mapping[HandednessSeries, Floats], count: int) -> tuple[str, ...]:
    flat, abstract = earned[FLAT], earned[CONCURRENT]
    return (
        "Features are the robot's own signals on every backend: position, velocity and volume of "
        "the object in both cameras, when an action is chosen. Half of the things are large, the "
        "others to the left or to the right; some of them move across at 5 cm/s.",
        "Flat: seven actions without compositions, and ten predicates, of which three encode "
        "motion, side and size. Moved joints stay in place. Concurrent: five abstract actions by "
        "Q-learning, allocations by ASSIMILATE, epsilon 0.2 for both until the end. Staged: 25 "
        "episodes with the right arm and small things that keep still on the right, then "
        "ASSIMILATE, in which the values of abstract actions are still learned, without "
        "exploration. It explores actions in 25 of 200 episodes. At equal times of exploration, it "
        "is compared with the concurrent learner whose actions are greedy after 25 episodes, too. "
        "Both explore allocations until the end.",
        f"Normalised: relative to the earnings of the best policy of a learner's actions in "
        f"{count} other episodes, which follows the tree of Figure 5.10: "
        f"{_with_interval('flat', flat)}, {_with_interval('concurrent and staged', abstract)}. "
        "A REACH and a TOUCH in sequence do not catch a moving object.",
        "Intervals in words and bands in pictures are means with 1.96 standard errors. A curve "
        "stays at the common level from where its mean over five episodes stays above 80 % of "
        f"{_LEVEL}; the drop ends at 80 % of the former value. An episode has 50 "
        "transitions at most, half of the source's, so that a hundred trials take an hour.",
    )


_RETRY_NOTES = (
    "Episodes of the second stage of the staged learner. A retry is a transition out of X1-, the "
    "reach at rest without contact, under another allocation than in the failed attempt.",
)
