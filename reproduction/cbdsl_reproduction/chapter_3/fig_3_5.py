"""Figure 3.5: a box with a barcode on the table, held in both hands, and at the optimum."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cbdsl_reproduction.chapter_3.barcode import barcodes
from cbdsl_reproduction.chapter_3.inspection import InspectionRun, Look, inspection
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import TAIL, resampled_interval
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, at_least, in_hindsight, near

# Six times as many trials as in the source, so that holding all boxes is not by chance.
_TRIALS, _QUICK_TRIALS = 60, 2
#: Depths of Table 3.2, m, and tolerance within which a depth counts as the same place.
_DEPTHS = {"table": 1.0, "held": 0.75, "optimum": 0.5}
_TOLERANCE = 0.1
_PRINTED = {"held": 0.95 / 0.43, "optimum": 0.95 / 0.14}
_SQUEEZE = 10.0  # N, the reference in the programs
_OFF = 0.1  # of the printed ratios, and of the reference of the forces
_STEADY = 2.0  # %, largest rise of a potential that descends, of its value at the start
_POINT = 6  # ticks between the points of the chart

_PLACE = "Section 3.3.3.2, Figure 3.5"
_HOLDS = Claim(_PLACE, "boxes held to the end", "%", "held", at_least(90))
_DEPTH = {
    place: Claim(_PLACE, f"depth, {place}", "m", f"{depth:g} m", near(depth, _TOLERANCE))
    for place, depth in _DEPTHS.items()
}
_RATIO = {
    place: Claim(
        _PLACE,
        f"φ_l on the table by φ_l, {place}",
        "",
        f"{printed:.2f}",
        near(printed, _OFF * printed),
        above(1.0),
    )
    for place, printed in _PRINTED.items()
}
_DESCENDS = Claim(
    _PLACE,
    f"boxes on whose way to the optimum φ_l rises by {_STEADY:g} % of its start at most",
    "%",
    "descends",
    at_least(90),
)
_SQUEEZES = Claim(
    _PLACE,
    f"boxes whose forces along the palms' normals err by {100 * _OFF:g} % in the mean at most",
    "%",
    "the hold is kept",
    in_hindsight(at_least(90)),
)
CLAIMS: Claims = {"fig-3.5": (_HOLDS, *_DEPTH.values(), *_RATIO.values(), _DESCENDS, _SQUEEZES)}

_NOTES = (
    "An experimenter holds the box out between the hands, its print towards the cameras, and lets "
    "go after two seconds. The program grabs it with the fingertips of both hands (TOUCH), and "
    "then runs LOCALIZABILITY subject to that hold until a camera stops seeing all of the box.",
    "The source presses with 0.2 N. Here 10 N along each palm's normal hold a box of 150 g.",
    "Further levels keep the object between the hands in place: the palms keep facing each "
    "other, and stay level with each other. Forces along two normals alone let the box turn.",
    "The field of view ends the approach: nearer, the box does not fit into both images. The "
    "source does not state the end of its approach.",
)


def run(settings: RunSettings) -> Result:
    """Record looks at boxes on the table and in the hands."""
    trials = _QUICK_TRIALS if settings.quick else _TRIALS
    everything = [barcode for each in barcodes().values() for barcode in each]
    on_table: list[Look] = []
    in_hands: list[InspectionRun] = []
    with inspection() as dexter:
        for trial in range(trials):
            barcode, seed = everything[trial % len(everything)], settings.seed + trial
            on_table.append(dexter.on_table(barcode, seed))
            in_hands.append(dexter.in_hands(barcode, seed))
            settings.progress(trial + 1, trials)
        period = dexter.period
    return Result(
        tuple(_quantities(on_table, in_hands, settings.seed)), _charts(in_hands, period), _NOTES
    )


def _quantities(
    on_table: Sequence[Look], in_hands: Sequence[InspectionRun], seed: int
) -> Iterator[Quantity]:
    yield _held(in_hands)
    looks = {
        "table": list(on_table),
        "held": [each.held for each in in_hands if each.held is not None],
        "optimum": [each.optimum for each in in_hands if each.optimum is not None],
    }
    for place, claim in _DEPTH.items():
        yield mean_of(claim, [look.depth for look in looks[place]], seed=seed)
    for place, tick in (("held", 0), ("optimum", -1)):
        # A trial whose box was never in both hands has no second end.
        ends = [
            (look.phi, inspected.phis[tick])
            for look, inspected in zip(on_table, in_hands, strict=True)
            if inspected.phis
        ]
        yield _ratio(place, ends, seed)
    yield _descents(in_hands)
    yield _force_errors(in_hands)


def _descents(in_hands: Sequence[InspectionRun]) -> Quantity:
    # A box that was never in both hands counts as a failure.
    rises = [_rise(each.phis) if each.phis else math.inf for each in in_hands]
    steady = sum(rise <= _STEADY for rise in rises)
    largest = max((rise for rise in rises if math.isfinite(rise)), default=math.nan)
    return percentage(
        _DESCENDS,
        steady,
        len(rises),
        note=f"largest rise {largest:.2g} %, while the box is in both hands",
    )


def _force_errors(in_hands: Sequence[InspectionRun]) -> Quantity:
    errors = [
        float(np.mean([np.abs(force - _SQUEEZE) for force in each.forces]))
        if each.forces
        else math.inf
        for each in in_hands
    ]
    kept = sum(error <= _OFF * _SQUEEZE for error in errors)
    largest = max((error for error in errors if math.isfinite(error)), default=math.nan)
    return percentage(
        _SQUEEZES,
        kept,
        len(errors),
        note=f"the reference is {_SQUEEZE:g} N; largest mean error {largest:.2g} N",
    )


def _held(in_hands: Sequence[InspectionRun]) -> Quantity:
    held, trials = sum(each.is_held for each in in_hands), len(in_hands)
    slips = [100 * each.slip for each in in_hands if each.held is not None]
    note = f"largest slip in the hands {max(slips):.1f} cm" if slips else ""
    return percentage(_HOLDS, held, trials, note=note)


def _ratio(place: str, ends: Sequence[tuple[float, float]], seed: int) -> Quantity:
    """Return the ratio of phi_l on the table to phi_l at a place, of the same trials."""
    return Quantity(
        _RATIO[place],
        _quotient(ends),
        resampled_interval(ends, _quotient, seed) if len(ends) > 1 else None,
        TAIL,
        note="at the depths above, which differ a little from the source's",
    )


def _quotient(ends: Sequence[tuple[float, float]]) -> float:
    """Return the mean of the first ends divided by the mean of the second ones."""
    first, second = np.mean(ends, axis=0) if ends else (math.nan, math.nan)
    return float(first / second)


def _rise(phis: Sequence[float]) -> float:
    """Return the largest rise of a curve above its previous minimum, % of its start."""
    curve = np.array(phis)
    return 100 * float((curve - np.minimum.accumulate(curve)).max() / curve[0])


def _charts(in_hands: Sequence[InspectionRun], period: float) -> tuple[Chart, ...]:
    curves = [each.phis for each in in_hands if each.phis][:4]
    if not curves:
        return ()
    lines = tuple(
        Line(
            f"episode {number}",
            tuple(tick * period for tick in range(0, len(curve), _POINT)),
            tuple(curve[tick] for tick in range(0, len(curve), _POINT)),
        )
        for number, curve in enumerate(curves, 1)
    )
    title = "Localizability subject to a hold in both hands"
    return (Chart("fig-3.5-localizability", title, "time, s", "φ_l, m²/rad²", lines),)
