"""Trackable loads and stiffness of the contact of two objects (Figures 7.13 and 7.14)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from cbdsl.api.learning import DIRECTIONS, ImpedanceProfile
from cbdsl_reproduction.bar_chart import Bar, BarChart
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.impedance_trials import ImpedanceTrial, impedance_digest, run_trials
from cbdsl_reproduction.kept_trials import kept_trials
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.thing_pairs import PAIRS

Profiles = Mapping[str, Sequence[ImpedanceProfile]]

# The source ran each pair five times.
_TRIALS, _QUICK_TRIALS = 20, 1
_RIGHT = 80.0  # % of the signs

_PLACE = "Section 7.2, Figure 7.13"
_BROUGHT = {
    name: Claim(_PLACE, f"{name.replace('_', ' ')}: brought together and tested", "%")
    for name in PAIRS
}
# A coin is right in half of the directions, so that more than 50 % preserve the order at least.
_TRACKED = {
    name: Claim(
        _PLACE,
        f"{name.replace('_', ' ')}: directions tracked as there",
        "%",
        f"{', '.join(pair.stiff)}; not {', '.join(pair.free)}",
        above(_RIGHT),
        ordering=above(50),
    )
    for name, pair in PAIRS.items()
}
CLAIMS: Claims = {"fig-7.13-7.14": (*_BROUGHT.values(), *_TRACKED.values())}

_NOTES = (
    "A hand sets one thing on the other, or 5 cm into it with 1 cm of clearance on every side, and "
    "runs twelve tests: along the axes of the world frame until 2 N more are felt or the palm has "
    "moved by 2 cm, and about them, through the palm, until 0.1 N m or 6 deg (25 deg about z). "
    "Before each test it makes contact anew, with 1 N, or 0.5 N where it tests z and 3 N where it "
    "turns; after it, it returns to its previous pose. Loads are those of the fingertips, "
    "displacements those of the palm.",
    "The source tracks 2 N m. A grip of 6 N at 4 cm slips at about 0.2 N m.",
    "A direction counts as tracked where it was one way or the other. Those in which friction "
    "decides are not judged: a ball on a box slides or not.",
    "Impedances are shares of the largest of a trial, forces and torques apart, means over trials; "
    "of both ways the larger one.",
)


def run(settings: RunSettings) -> Result:
    """Measure the impedance of the six pairs."""
    count = settings.trials or (_QUICK_TRIALS if settings.quick else _TRIALS)
    seeds = range(settings.seed, settings.seed + count)
    trials = kept_trials(
        settings.folder / f"{settings.backend}_{settings.cameras}.jsonl",
        dict.fromkeys(PAIRS, seeds),
        impedance_digest,
        ImpedanceTrial,
        partial(run_trials, engine=settings.backend, cameras=settings.cameras),
        settings.progress,
    )
    profiles = {
        name: [each.profile for each in own if each.profile.is_whole]
        for name, own in trials.items()
    }
    quantities = tuple(
        quantity for name in PAIRS for quantity in _quantities(name, count, profiles[name])
    )
    return Result(quantities, tuple(_charts(profiles)), _NOTES)


def _quantities(name: str, count: int, profiles: Sequence[ImpedanceProfile]) -> Iterator[Quantity]:
    # Incomplete profiles count here alone: a missing
    # test would read as a load that was not tracked.
    yield percentage(_BROUGHT[name], len(profiles), count)
    # Directions in which friction decides are in neither list of the pair, and have no sign.
    rights = [PAIRS[name].right(profile.tracked()) for profile in profiles]
    # Signs of one profile are not independent.
    yield clustered_percentage(
        _TRACKED[name],
        [sum(own) for own in rights],
        [len(own) for own in rights],
        of="signs",
    )


def _charts(profiles: Profiles) -> Iterator[BarChart]:
    for name, own in profiles.items():
        label, count = name.replace("_", " "), max(len(own), 1)
        likely = [sum(each.tracked()[d] for each in own) / count for d in DIRECTIONS]
        stiff = [sum(each.normalized()[d] for each in own) / count for d in DIRECTIONS]
        yield BarChart(
            f"fig-7.13-{name}", f"Tracked loads, {label}",
            tuple(map(Bar, DIRECTIONS, likely)), "share of trials",
        )  # fmt: skip
        yield BarChart(
            f"fig-7.14-{name}", f"Impedance, {label}",
            tuple(map(Bar, DIRECTIONS, stiff)), "share of the largest",
        )  # fmt: skip
