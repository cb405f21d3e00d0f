"""Learned internal models: configurations of expected rewards (Figures 4.4 c and 4.8 b)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.api.control import Kinematics
from cbdsl.api.documents import Gaussian, Kernel
from cbdsl.api.shipped import shipped_robot
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import estimate
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import interquartile_mean, interval_of
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, below
from cbdsl_reproduction.series import COARTICULATED, TACTILEPROBE, Series
from cbdsl_reproduction.trial_runner import LearnedTrial, TrialRunner, trial_runner

Floats = NDArray[np.float64]

_ROBOT, _POINTS = "dexter", 181
# Half-way between objects presented in front and the window, at which the head pans 1.34 rad.
_BORDER = 0.67
# Number of resampled sets of trials with uniform rewards, and percentile for the chance bound, %.
_DRAWS, _TAIL = 200, 97.5

# The bounds are passed by one of 40 sets of trials with rewards at uniform angles.
_PEAK = Claim(
    "Section 4.2.1, Figure 4.4",
    "after {episodes} episodes: density of the peak {where}, by the lowest between the peaks",
    "",
    "a peak",
    bound=above,
)
_IN_FRONT, _AT_WINDOW = "in front", "at the window"
_LARGER = Claim(
    "Section 4.2.1, Figure 4.4",
    "after {episodes} episodes: {measure} in front by that at the window",
    "",
    "the peak in front is the larger one",
    above(1),
)
_NARROW = Claim(
    "Section 4.2.2, Figure 4.8",
    "after {episodes} episodes: {joint}: deviation by that of the uniform density",
    "",
    "one Gaussian a finger",
    bound=below,
)


@dataclass(frozen=True)
class Expectation:
    """Learned densities of the trials of a series for one joint.

    Attributes:
        joint: Joint of the effector.
        lower, upper: Limits of the joint, rad.
        densities: Densities of its angle at the end of each trial, 1/rad, shape (trials, points).
            The points are evenly spaced from the lower to the upper limit.
        anywhere: Densities of models that learned as many rewards at uniform angles, 1/rad, shape
            (draws, trials, points).
    """

    joint: str
    lower: float
    upper: float
    densities: Floats
    anywhere: Floats

    @property
    def angles(self) -> Floats:
        """Angles of the points, rad."""
        angles: Floats = np.linspace(self.lower, self.upper, self.densities.shape[1])
        return angles

    def deviations(self, densities: Floats) -> Floats:
        """Return the standard deviations of densities (..., points), rad, shape (...)."""
        weights = densities / densities.sum(axis=-1, keepdims=True)
        means = weights @ self.angles
        spread: Floats = np.sqrt(weights @ self.angles**2 - means**2)
        return spread


def _peaks(expectations: Sequence[Expectation], seed: int) -> Iterator[Quantity]:
    """Yield quantities of a large peak in front and a smaller one at the window (Section 4.2.1)."""
    (pan,) = expectations
    front = pan.angles < _BORDER
    measured, anywhere = (prominences(each, front) for each in (pan.densities, pan.anywhere))
    for index, where in enumerate((_IN_FRONT, _AT_WINDOW)):
        bound = _passed_by_chance(anywhere[..., index], _TAIL)
        note = f"rewards at uniform angles reach {bound:.3g} in one of 40 draws"
        yield _ratio(_PEAK.named(where=where).at(bound), measured[..., index], seed, note)
    heights = [pan.densities[:, points].max(axis=1) for points in (front, ~front)]
    masses = [pan.densities[:, points].sum(axis=1) for points in (front, ~front)]
    for measure, (first, second) in (("height", heights), ("mass", masses)):
        yield _ratio(_LARGER.named(measure=measure), first / second, seed)


def prominences(densities: Floats, front: NDArray[np.bool_]) -> Floats:
    """Return the heights of the two peaks divided by the lowest density between them.

    Args:
        densities: Densities, shape (..., points).
        front: Mask of the leading points, which contain the first peak, shape (points,).

    Returns:
        Ratios of the peak in front and of the other peak, shape (..., 2).
    """
    border = int(front.sum())
    rows = densities.reshape(-1, densities.shape[-1])
    ratios = []
    for row in rows:
        # The lowest density between the maxima is the valley. A density
        # without a valley has a ratio of 1 for its lower maximum.
        first, second = int(row[:border].argmax()), border + int(row[border:].argmax())
        ratios.append(row[[first, second]] / row[first : second + 1].min())
    return np.array(ratios).reshape(*densities.shape[:-1], 2)


def _passed_by_chance(values: Floats, tail: float) -> float:
    """Return a percentile of the interquartile means of draws, shape (draws, trials)."""
    return float(np.percentile(interquartile_mean(values.T), tail))


def _narrowing(expectations: Sequence[Expectation], seed: int) -> Iterator[Quantity]:
    """Yield quantities about the spread of each finger's flexion in contact (Section 4.2.2)."""
    for each in expectations:
        # Standard deviation of the uniform density.
        started = (each.upper - each.lower) / np.sqrt(12)
        measured, anywhere = (
            each.deviations(densities) / started for densities in (each.densities, each.anywhere)
        )
        bound = _passed_by_chance(anywhere, 100 - _TAIL)
        radians = interquartile_mean(measured * started)
        yield _ratio(
            _NARROW.named(joint=each.joint).at(bound),
            measured,
            seed,
            f"{radians:.2f} rad; contacts at uniform angles fall to {bound:.3g} in one of 40 draws",
        )


def _ratio(claim: Claim, values: Floats, seed: int, note: str = "") -> Quantity:
    """Return the interquartile mean over trials as a quantity."""
    interval = interval_of(interquartile_mean, seed)
    return estimate(claim, values, interquartile_mean, interval, seed=seed, note=note)


@dataclass(frozen=True)
class DrawnModel:
    """Internal model that the source shows.

    Attributes:
        series: Series of trials in which it is learned.
        effector: Effector whose configurations it describes.
        joints: Shown joints of the effector.
        after: Numbers of episodes from which it is learned; two if the source is contradictory.
        quantities: Function that yields the quantities of the model.
        title: Title of the picture.
    """

    series: Series
    effector: str
    joints: tuple[str, ...]
    after: tuple[int, ...]
    quantities: Callable[[Sequence[Expectation], int], Iterator[Quantity]]
    title: str


_FINGERS = ("right_finger_1", "right_finger_2", "right_finger_3")
#: By figure.
MODELS: Mapping[str, DrawnModel] = {
    # The caption says 25, and the text the end of a trial.
    "fig-4.4": DrawnModel(
        COARTICULATED, "head", ("pan",), (25, 50), _peaks, "Where TRACK is expected"
    ),
    "fig-4.8": DrawnModel(
        TACTILEPROBE, "right_hand", _FINGERS, (25,), _narrowing, "Where contact is expected"
    ),
}

CLAIMS: Claims = {
    "fig-4.4": tuple(
        claim.named(episodes=str(episodes))
        for episodes in MODELS["fig-4.4"].after
        for claim in (
            *(_PEAK.named(where=where) for where in (_IN_FRONT, _AT_WINDOW)),
            *(_LARGER.named(measure=measure) for measure in ("height", "mass")),
        )
    ),
    "fig-4.8": tuple(
        _NARROW.named(joint=joint, episodes=str(episodes))
        for episodes in MODELS["fig-4.8"].after
        for joint in _FINGERS
    ),
}


def run(settings: RunSettings, name: str) -> Result:
    """Learn, and evaluate the densities that SEARCH finally draws from."""
    model = MODELS[name]
    with trial_runner(settings) as dexter:
        learned = gather(dexter, settings, name)
    shown = {}
    for episodes in _moments(model, learned):
        known = _known(model, [each.after(episodes) for each in learned])
        if known:
            shown[episodes] = _expectations(model, known, settings.seed)
    quantities = [
        replace(quantity, claim=quantity.claim.named(episodes=str(episodes)))
        for episodes, expectations in shown.items()
        for quantity in model.quantities(expectations, settings.seed)
    ]
    if not shown:
        return Result((), notes=(f"No trial found a reward with {model.effector}.",))
    note = (
        f"Densities of {len(learned)} trials; interquartile means with bootstrap intervals, over "
        "the trials rewarded by that time. Each has the uniform part that it starts as."
    )
    return Result(tuple(quantities), (_chart(name, model, shown),), (note,))


def _moments(model: DrawnModel, learned: Sequence[LearnedTrial]) -> list[int]:
    """Return the numbers of episodes after which to evaluate, limited to the existing ones."""
    episodes = len(learned[0].trial.experiences)
    return sorted({min(after, episodes) for after in model.after})


class Known(NamedTuple):
    """Density that a trial has learned, and the number of rewards behind it."""

    density: Kernel | Gaussian
    rewards: int


def _known(model: DrawnModel, learned: Sequence[LearnedTrial]) -> list[Known]:
    """Return the densities of the trials in which the effector was rewarded."""
    known = []
    for each in learned:
        density = each.trial.learner.densities().get(model.effector)
        rewards = sum(model.effector in one.rewarded for one in each.trial.experiences)
        if density is not None:
            known.append(Known(density, rewards))
    return known


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials."""
    return (MODELS[name].series,)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> list[LearnedTrial]:
    """Run all episodes, and return the learned trials."""
    (series,) = series_of(name)
    dexter.expect(len(dexter.numbers(series)) * dexter.episodes(series))
    return dexter.learn(series)


def _expectations(model: DrawnModel, known: Sequence[Known], seed: int) -> list[Expectation]:
    robot, urdf = shipped_robot(_ROBOT)
    kinematics = Kinematics(robot, urdf)
    columns = kinematics.joints.of(model.effector)
    names = robot.joints(model.effector)
    rng = np.random.default_rng(seed)
    expectations = []
    for joint in model.joints:
        place = names.index(joint)
        lower, upper = (
            float(limits[columns[place]]) for limits in (kinematics.lower, kinematics.upper)
        )
        angles = np.linspace(lower, upper, _POINTS)
        rows = [marginal(each.density, place, angles) for each in known]
        drawn = [[anywhere(each, place, angles, rng) for each in known] for _ in range(_DRAWS)]
        expectations.append(Expectation(joint, lower, upper, np.array(rows), np.array(drawn)))
    return expectations


def anywhere(known: Known, joint: int, angles: Floats, rng: np.random.Generator) -> Floats:
    """Return the density of a joint's angle for rewards at uniform angles, 1/rad."""
    # Null hypothesis: rewards do not depend on the posture. Few rewards at uniform angles also
    # cluster by chance, which bounds the peaks and the deviations that count as learned.
    drawn = rng.uniform(angles[0], angles[-1], known.rewards)
    density = known.density
    if isinstance(density, Kernel):
        deviation = density.bandwidth[joint]
        return _mixture(drawn, deviation, density.uniform, angles)
    spread = max(float(drawn.std()), min(density.deviation))
    return _mixture(np.array([drawn.mean()]), spread, density.uniform, angles)


def marginal(density: Kernel | Gaussian, joint: int, angles: Floats) -> Floats:
    """Return the density of one joint's angle, 1/rad; the limits are the first and last angle.

    Args:
        density: Density over all joints.
        joint: Index of the joint.
        angles: Angles at which to evaluate the density, rad.
    """
    if isinstance(density, Kernel):
        centres, deviation = np.array(density.samples)[:, joint], density.bandwidth[joint]
    else:
        centres, deviation = np.array([density.mean[joint]]), density.deviation[joint]
    return _mixture(centres, deviation, density.uniform, angles)


def _mixture(centres: Floats, deviation: float, uniform: float, angles: Floats) -> Floats:
    """Return a mixture of Gaussians of equal deviation around the centres and a uniform part."""
    # The part of a kernel beyond the limits is cut off and not redistributed.
    offsets = (angles - centres[:, None]) / deviation
    bells = np.exp(-(offsets**2) / 2) / (deviation * np.sqrt(2 * np.pi))
    evenly = uniform / (angles[-1] - angles[0])
    total: Floats = evenly + (1 - uniform) * bells.mean(axis=0)
    return total


def _chart(name: str, model: DrawnModel, shown: Mapping[int, Sequence[Expectation]]) -> Chart:
    lines = tuple(
        Line(
            f"{each.joint}, after {episodes} episodes",
            tuple(each.angles.tolist()),
            tuple(interquartile_mean(each.densities).tolist()),
        )
        for episodes, expectations in shown.items()
        for each in expectations
    )
    return Chart(
        name, f"{model.title}, {model.series.label}", "angle, rad", "density, 1/rad", lines
    )
