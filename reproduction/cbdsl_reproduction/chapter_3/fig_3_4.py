"""Figure 3.4: reach alone, and with the range or the manipulability potential below.

The arm reaches for a ball at 56 places under each of three laws. All three potentials are evaluated
in every tick of every reach from the robot's own signals, whether or not the law lowers them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.api.control import Floats, Potential, manipulability_potential, range_potential
from cbdsl.api.documents import StageDocument
from cbdsl.api.program import WrittenPolicy
from cbdsl.api.sensing import EpisodeListeners, Runner, Tick
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.interval import TAIL, resampled_interval
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, at_least, at_most, below
from cbdsl_reproduction.simulation_fixture import SimulationFixture, simulation_fixture

_ARM, _REACH = "right_arm", "reach"
#: The shipped reach also points the hand, which leaves less to the potentials below.
PROGRAM = Path(__file__).with_name("reach_ball.yaml")
#: Actions of the program by the source's names of the laws.
_LAWS = {"c0": _REACH, "c1": f"posturalbias ◁ {_REACH}", "c2": f"manipulability ◁ {_REACH}"}

# Area of the source, 0.4 m x 0.8 m, over the table in front of the robot, m.
_PLACES = tuple(product(np.linspace(0.32, 0.72, 8).tolist(), np.linspace(-0.4, 0.4, 7).tolist()))
_QUICK_PLACES = (_PLACES[0], _PLACES[24])
_RADIUS = 0.03
# Height of the ball's centre, m: 8 cm above the table. If the ball lay on the table, an arm drawn
# to the middle of its limits would rest on the table in reaches to the other side.
_HEIGHT = -0.34

# Posture nearest to the middle of the joints' limits by the range potential, among the postures
# with the hand at (0.3, -0.5, -0.2) m and the palm down.
_START = (1.09, -1.62, 0.15, 2.30, -2.91, 0.69, -0.07)
# A closed hand neither gets caught nor pushes.
_FINGERS, _FIST = ("right_finger_1", "right_finger_2", "right_finger_3"), (2.4, 2.4, 2.4)
_ARRIVED = 0.01  # m
_STEADY = 1.0  # %, largest rise of a steadily falling potential, relative to its initial value
_MARGIN = 0.05  # share of a change below which a difference is ignored
_POINT = 3  # ticks between the points of a chart

_PLACE = "Section 3.3.3.1, Figure 3.4"
_ARRIVES = Claim(_PLACE, "reaches that come to rest at the ball", "%", "all", at_least(95))
_FALLS = Claim(
    _PLACE,
    "{law}: largest rise of the mean φ_s, of its start",
    "%",
    "falls steadily to the goal",
    at_most(_STEADY),
)
# The bound is a share of the change under the reach alone.
_LESS = Claim(
    _PLACE,
    "rise of {symbol} during the reach, {law} less c0",
    "",
    "rises less under {law}",
    bound=below,
)
_PLACES_LESS = Claim(
    _PLACE, "places where {symbol} rises less under {law}", "%", "on average", above(50)
)
#: Symbols of the potentials by the laws that lower them.
_LOWERED = {"c1": "φ_r", "c2": "φ_m"}
CLAIMS: Claims = {
    "fig-3.4": (
        _ARRIVES,
        *(_FALLS.named(law=law) for law in _LAWS),
        *(
            claim.named(law=law, symbol=symbol)
            for law, symbol in _LOWERED.items()
            for claim in (_LESS, _PLACES_LESS)
        ),
    )
}

_NOTES = (
    "Three potentials of the right arm of Dexter on the simulator, from the start of each reach "
    "until it is at rest: the spring's, the range potential's and that of manipulability. A reach "
    "that is over keeps its last values in the mean curves.",
    "The source starts from the middle of the joints' limits. On this robot that hangs the hand "
    "behind the body and 16 cm below the top of the table, which is in the way of every reach. "
    "Ours starts beside the places, where the hand hides none of them from the cameras, palm down, "
    "in the posture that is nearest to the middle by the range potential. Postures that are nearer "
    "still turn the back of the hand to the table, and push against the ball. So the range "
    "potential is not at its minimum at the start, and falls where the source's rises; the "
    "change is compared.",
    "The ball is held 5 cm above the table: on it, an arm that the range potential draws to the "
    "middle of its limits touched the table in 12 of 56 reaches, and came to rest short of the "
    "ball in 7. The ball stays where it is when it is touched, and the hand is closed: a reach "
    "controls the position of the hand alone, which tilts on its way, and open fingers got caught "
    "by the top of the table. The point that is brought to the ball is 9 cm in front of the palm.",
)


def run(settings: RunSettings) -> Result:
    """Reach for every place under every law."""
    places = _QUICK_PLACES if settings.quick else _PLACES
    reaches: dict[str, list[_Reach]] = {law: [] for law in _LAWS}
    with simulation_fixture(str(PROGRAM)) as lab:
        for number, (law, index) in enumerate(product(_LAWS, range(len(places))), start=1):
            runner = lab.runner(_policy(lab.program.policy, _LAWS[law]))
            stage, seed = _stage(lab, places[index]), settings.seed + index
            reaches[law].append(_reach(lab, runner, stage, _LAWS[law], seed))
            settings.progress(number, len(_LAWS) * len(places))
        period = lab.backend.control_period
    quantities = tuple(_quantities(reaches, settings.seed))
    return Result(quantities, _charts(reaches, period), _NOTES)


@dataclass
class _Reach:
    """Potentials in every tick of one reach, and its outcome."""

    spring: list[float] = field(default_factory=list)
    range: list[float] = field(default_factory=list)
    manipulability: list[float] = field(default_factory=list)
    error: float = math.inf
    at_rest: bool = False
    touched: bool = False

    @property
    def arrived(self) -> bool:
        return self.at_rest and self.error < _ARRIVED


def _policy(written: Mapping[str, str], action: str) -> WrittenPolicy:
    """Return the program's policy with another law in place of the reach."""
    return WrittenPolicy(
        {state: action if name == _REACH else name for state, name in written.items()}
    )


def _stage(lab: SimulationFixture, place: tuple[float, float]) -> StageDocument:
    """Return the program's stage with a ball at one place, and the arm at its start."""
    x, y = place
    radius, joints = (_RADIUS, _RADIUS), lab.robot.effectors[_ARM].joints + _FINGERS
    ball: dict[str, Any] = {"form": {"shape": "ball", "radius": radius}, "mass": (0.3, 0.3)}
    context = {
        "things": ["ball"],
        "place": {"x": (x, x), "y": (y, y), "z": (_HEIGHT, _HEIGHT), "held": True},
        "joints": {
            joint: (angle, angle) for joint, angle in zip(joints, _START + _FIST, strict=True)
        },
    }
    changes = {"things": {"ball": ball}, "contexts": {"place": context}}
    return StageDocument.model_validate(lab.stage.model_dump(by_alias=True) | changes)


def _reach(
    lab: SimulationFixture, runner: Runner, stage: StageDocument, action: str, seed: int
) -> _Reach:
    """Run one episode, and record the reach without the preceding search for the ball."""
    record = _Reach()
    columns = lab.kinematics.joints.of(_ARM)
    limits = lab.kinematics.lower[columns], lab.kinematics.upper[columns]
    range_, manipulability = range_potential(*limits), manipulability_potential(3, len(columns))

    def note(tick: Tick) -> None:
        if tick.run.action is None or tick.run.action.name != action:
            return
        reach = next(run for run in tick.run.runs if run.controller.name == _REACH)
        # The reach has no reference until the ball is found.
        if math.isnan(reach.phi):
            return
        posture = tick.signals.positions[columns]
        record.spring.append(reach.phi)
        record.range.append(_phi(range_, posture))
        record.manipulability.append(_phi(manipulability, _tip(tick, columns)))
        record.error, record.at_rest = reach.error, reach.predicate == "1"
        record.touched |= lab.backend.truth.touched("table")

    runner.run(stage, seed, observer=EpisodeListeners(on_tick=note))
    return record


def _phi(potential: Potential, value: Floats) -> float:
    """Return the value of a potential without a reference."""
    return potential.evaluate(value, np.zeros(0), len(value))[0]


def _tip(tick: Tick, columns: Any) -> Floats:
    """Return the arm's manipulator Jacobian with respect to its own joints, row by row."""
    signals = tick.signals
    names = [signals.joints.names[column] for column in columns]
    tip = signals.reading(signals.kinematic_rows.manipulator(_ARM, "position", names))
    assert tip is not None
    return tip.value


def _quantities(reaches: Mapping[str, Sequence[_Reach]], seed: int) -> Iterator[Quantity]:
    places = list(zip(*reaches.values(), strict=True))
    yield clustered_percentage(
        _ARRIVES,
        [sum(reach.arrived for reach in own) for own in places],
        list(map(len, places)),
        note=_touching(reaches),
    )
    for law, runs in reaches.items():
        yield _fall(law, runs, seed)
    yield from _less("range", reaches["c1"], reaches["c0"], "c1", seed)
    yield from _less("manipulability", reaches["c2"], reaches["c0"], "c2", seed)


def _touching(reaches: Mapping[str, Sequence[_Reach]]) -> str:
    """Return a note about the numbers of reaches in which the arm touched the table."""
    counts = {law: sum(reach.touched for reach in runs) for law, runs in reaches.items()}
    return "the arm touched the table in " + ", ".join(
        f"{n} under {law}" for law, n in counts.items()
    )


def _fall(law: str, runs: Sequence[_Reach], seed: int) -> Quantity:
    """Return the largest rise of the spring's potential as a quantity."""
    single = sum(_rise([reach.spring]) <= _STEADY for reach in runs)
    curves = [reach.spring for reach in runs if reach.spring]
    return Quantity(
        _FALLS.named(law=law),
        _rise(curves),
        interval=resampled_interval(curves, _rise, seed) if len(curves) > 1 else None,
        chance=TAIL,
        note=f"so it is in {single} of {len(runs)} reaches by themselves",
    )


def _rise(curves: Sequence[Sequence[float]]) -> float:
    """Return the largest rise of the mean curve above its previous minimum, % of its start."""
    if not any(curves):
        return math.nan
    curve = _mean(curves)
    return 100 * float((curve - np.minimum.accumulate(curve)).max() / curve[0])


def _less(
    potential: str,
    under: Sequence[_Reach],
    alone: Sequence[_Reach],
    law: str,
    seed: int,
) -> Iterator[Quantity]:
    """Yield the difference in the rise of a potential between a law and the reach alone."""
    pairs = [
        (_change(getattr(ours, potential)), _change(getattr(other, potential)))
        for ours, other in zip(under, alone, strict=True)
        if getattr(ours, potential) and getattr(other, potential)
    ]
    differences = [ours - other for ours, other in pairs]
    changes = np.mean(pairs, axis=0) if pairs else (math.nan, math.nan)
    # The margin is relative to the change without the law, so that numerical noise does not count
    # as a difference.
    margin = _MARGIN * abs(float(changes[1])) if pairs else 0.0
    parts = {"law": law, "symbol": _LOWERED[law]}
    yield mean_of(
        _LESS.named(**parts).at(-margin),
        differences,
        seed=seed,
        note=f"mean change {changes[0]:.3g} under {law}, {changes[1]:.3g} under c0; all reaches",
    )
    less = sum(difference < 0 for difference in differences)
    yield percentage(_PLACES_LESS.named(**parts), less, len(alone))


def _change(curve: Sequence[float]) -> float:
    return curve[-1] - curve[0]


def _mean(curves: Sequence[Sequence[float]]) -> Floats:
    """Return the mean over non-empty curves, each extended by its last value to the longest."""
    longest = max(map(len, curves))
    begun = [curve for curve in curves if curve]
    padded = [[*curve, *[curve[-1]] * (longest - len(curve))] for curve in begun]
    mean: Floats = np.mean(padded, axis=0)
    return mean


def _charts(reaches: Mapping[str, Sequence[_Reach]], period: float) -> tuple[Chart, ...]:
    if not all(any(reach.spring for reach in runs) for runs in reaches.values()):
        return ()
    shown = (
        ("spring", "φ_s, m²", tuple(_LAWS)),
        ("range", "φ_r", ("c0", "c1")),
        ("manipulability", "φ_m, m³", ("c0", "c2")),
    )
    return tuple(
        Chart(
            f"fig-3.4-{potential}",
            f"Mean potential of {len(reaches['c0'])} reaches: {potential}",
            "time since the start of the reach, s",
            label,
            tuple(_line(law, reaches[law], potential, period) for law in laws),
        )
        for potential, label, laws in shown
    )


def _line(law: str, runs: Sequence[_Reach], potential: str, period: float) -> Line:
    mean = _mean([getattr(reach, potential) for reach in runs])
    points = range(0, len(mean), _POINT)
    name = {"c0": "c0, reach alone", "c1": "c1, range below", "c2": "c2, manip. below"}[law]
    return Line(name, tuple(k * period for k in points), tuple(float(mean[k]) for k in points))
