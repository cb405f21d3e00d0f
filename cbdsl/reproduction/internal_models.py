"""Internal models that were learned: where rewards are expected (Figures 4.4 c and 4.8 b)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.reproduction.chart import Chart, Line
from cbdsl.reproduction.experiment import Result, RunSettings
from cbdsl.reproduction.interval import interquartile_mean, over_trials
from cbdsl.reproduction.quantity import Quantity, above, below, clearly_above, clearly_below
from cbdsl.reproduction.series import COARTICULATED, TACTILEPROBE, Series
from cbdsl.reproduction.shipped import shipped_robot
from cbdsl.reproduction.trial_runner import LearnedTrial, TrialRunner, trial_runner
from cbdsl.sensing.kinematics import Kinematics

Floats = NDArray[np.float64]

_ROBOT, _POINTS = "dexter", 181
# Half-way between what is presented in front and the window, at which the head pans 1.34 rad.
_BORDER = 0.67


@dataclass(frozen=True)
class Expectation:
    """The expectations of the trials of a series for one joint.

    Attributes:
        joint: of the effector.
        lower, upper: its limits, rad.
        densities: of its angle at the end of each trial, 1/rad, shape (trials, points), over
            points evenly from the lower limit to the upper one.
    """

    joint: str
    lower: float
    upper: float
    densities: Floats

    @property
    def angles(self) -> Floats:
        """The points, rad."""
        angles: Floats = np.linspace(self.lower, self.upper, self.densities.shape[1])
        return angles

    @property
    def uniform(self) -> float:
        """The density that it started as, 1/rad."""
        return 1 / (self.upper - self.lower)

    @property
    def deviations(self) -> Floats:
        """Standard deviations, rad, shape (trials,)."""
        weights = self.densities / self.densities.sum(axis=1, keepdims=True)
        means = weights @ self.angles
        spread: Floats = np.sqrt(weights @ self.angles**2 - means**2)
        return spread


def _peaks(expectations: Sequence[Expectation], seed: int) -> Iterator[Quantity]:
    """A large peak in front, and a smaller one at the window (Section 4.2.1)."""
    (pan,) = expectations
    front = pan.angles < _BORDER
    heights = [pan.densities[:, where].max(axis=1) for where in (front, ~front)]
    masses = [pan.densities[:, where].sum(axis=1) for where in (front, ~front)]
    for place, height in zip(("in front", "at the window"), heights, strict=True):
        times = height / pan.uniform
        yield _quantity(f"density of the peak {place}, by the uniform one", "a peak", times, seed)
    source = "the peak in front is the larger one"
    yield _quantity("height in front by that at the window", source, heights[0] / heights[1], seed)
    yield _quantity("mass in front by that at the window", source, masses[0] / masses[1], seed)


def _quantity(name: str, source: str, values: Floats, seed: int) -> Quantity:
    middle, interval = float(interquartile_mean(values)), over_trials(values, seed)
    return Quantity(name, "", source, middle, clearly_above(1), above(1), interval)


def _narrowing(expectations: Sequence[Expectation], seed: int) -> Iterator[Quantity]:
    """A distribution of each finger's flexion in contact (Section 4.2.2)."""
    for each in expectations:
        # That of the uniform density.
        started = (each.upper - each.lower) / np.sqrt(12)
        values = each.deviations / started
        yield Quantity(
            f"{each.joint}: deviation by that of the uniform density",
            "",
            "one Gaussian a finger",
            float(interquartile_mean(values)),
            clearly_below(1),
            below(1),
            over_trials(values, seed),
            note=f"{interquartile_mean(each.deviations):.2f} rad",
        )


@dataclass(frozen=True)
class DrawnModel:
    """An internal model that the source shows.

    Attributes:
        series: what it is learned with.
        effector: whose configurations it is about.
        joints: of the effector, those that are shown.
        after: how many episodes it is learned from; where the source contradicts itself, both.
        quantities: what is said of it.
        title: of the picture.
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


def run(settings: RunSettings, name: str) -> Result:
    """Learn, and look at the densities that SEARCH draws from in the end."""
    model = MODELS[name]
    with trial_runner(settings) as dexter:
        learned = gather(dexter, settings, name)
    shown = {}
    for episodes in _moments(model, learned):
        densities = _densities(model, [each.after(episodes) for each in learned])
        if densities:
            shown[episodes] = _expectations(model, densities)
    quantities = [
        replace(quantity, name=f"after {episodes} episodes: {quantity.name}")
        for episodes, expectations in shown.items()
        for quantity in model.quantities(expectations, settings.seed)
    ]
    if not shown:
        return Result((), notes=(f"No trial found a reward with {model.effector}.",))
    note = (
        f"Densities of {len(learned)} trials; interquartile means with bootstrap intervals, over "
        "those that were rewarded by then. Each has the uniform part that it starts as."
    )
    return Result(tuple(quantities), (_chart(name, model, shown),), (note,))


def _moments(model: DrawnModel, learned: Sequence[LearnedTrial]) -> list[int]:
    """After how many episodes to look, as far as there are as many."""
    episodes = len(learned[0].trial.experiences)
    return sorted({min(after, episodes) for after in model.after})


def _densities(model: DrawnModel, learned: Sequence[LearnedTrial]) -> list[Kernel | Gaussian]:
    """Of the trials in which the effector was rewarded."""
    known = (each.trial.learner.densities().get(model.effector) for each in learned)
    return [density for density in known if density is not None]


def series_of(name: str) -> tuple[Series, ...]:
    """The series of trials."""
    return (MODELS[name].series,)


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> list[LearnedTrial]:
    """Run all episodes; what was learned."""
    (series,) = series_of(name)
    dexter.expect(len(dexter.numbers(series)) * dexter.episodes(series))
    return dexter.learn(series)


def _expectations(model: DrawnModel, densities: Sequence[Kernel | Gaussian]) -> list[Expectation]:
    robot, urdf = shipped_robot(_ROBOT)
    kinematics = Kinematics(robot, urdf)
    columns = kinematics.joints.of(model.effector)
    names = robot.joints(model.effector)
    expectations = []
    for joint in model.joints:
        place = names.index(joint)
        lower, upper = (
            float(limits[columns[place]]) for limits in (kinematics.lower, kinematics.upper)
        )
        angles = np.linspace(lower, upper, _POINTS)
        rows = [marginal(density, place, angles) for density in densities]
        expectations.append(Expectation(joint, lower, upper, np.array(rows)))
    return expectations


def marginal(density: Kernel | Gaussian, joint: int, angles: Floats) -> Floats:
    """The density of one joint's angle, 1/rad, between limits at the first and the last angle.

    Args:
        density: of all joints.
        joint: which of them.
        angles: where it is asked for, rad.
    """
    if isinstance(density, Kernel):
        centres, deviation = np.array(density.samples)[:, joint], density.bandwidth[joint]
    else:
        centres, deviation = np.array([density.mean[joint]]), density.deviation[joint]
    offsets = (angles - centres[:, None]) / deviation
    bells = np.exp(-(offsets**2) / 2) / (deviation * np.sqrt(2 * np.pi))
    evenly = density.uniform / (angles[-1] - angles[0])
    total: Floats = evenly + (1 - density.uniform) * bells.mean(axis=0)
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
