"""Control law taken literally, beside ours (Eq 3.18 to 3.26).

As printed, a controller moves by -kappa J^# phi, where J is the gradient of phi, one row. A
subordinate controller moves in the nullspace of that row. Both are implemented only here, to show
their effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cbdsl.api.control import (
    Floats,
    Kinematics,
    Law,
    LawSettings,
    Level,
    Potential,
    Rule,
    Tips,
    manipulability_potential,
    range_potential,
    spring_potential,
)
from cbdsl.api.shipped import shipped_robot
from cbdsl_reproduction.chart import Chart, Line
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, at_least

# A planar arm of three links, m.
_LINKS = np.array([0.4, 0.3, 0.2])
_STARTS = 100
_PRINTED_STEPS, _DESCENT_STEPS = 6, 60

# An arm holds a position, while the range potential acts below.
_ROBOT, _ARM = "dexter", "right_arm"
_GOALS = 100
_HOLDING_STEPS, _LOWER_GAIN = 300, 0.01
_POINT = 3  # iterations between the points of the chart
_HELD = 1e-5  # m, the largest error that counts as holding
_SETTINGS = LawSettings(joint_step=0.1)

Move = Callable[[Floats], Floats]

_GROWS = Claim(
    "Section 3.1.3, Equation 3.18",
    "{law}: starts from which manipulability grows",
    "%",
    "optimises manipulability (Section 3.1.3 b)",
    at_least(95),
    ordering=above(50),
)
_KEEPS = Claim(
    "Section 3.3.2, Equations 3.19 to 3.26",
    f"{{law}}: reached goals that stay within {1000 * _HELD:g} mm of the hand",
    "%",
    "nothing below disturbs the superior objective (Section 3.3.2)",
    at_least(90),
)
_PRINTED, _OURS = "printed law", "ours"
CLAIMS: Claims = {
    "law-as-printed": tuple(
        claim.named(law=law) for claim in (_GROWS, _KEEPS) for law in (_PRINTED, _OURS)
    )
}

_NOTES = (
    "The rows about the printed law take it literally: a miss there means that the equations do "
    "not serve the source's purpose, and explains the difference to ours.",
    f"Manipulability: a planar arm with links of {', '.join(f'{100 * x:g}' for x in _LINKS)} cm at "
    f"random postures; {_PRINTED_STEPS} steps of gain 1 as printed, {_DESCENT_STEPS} of ours, "
    "which follow the gradient since the minimum of this potential is not known. Priority: the "
    f"right arm of Dexter at random goals; {_HOLDING_STEPS} iterations with gain 1 for the spring "
    f"and {_LOWER_GAIN:g} for the range potential. Kinematics only, without simulator.",
)


def run(settings: RunSettings) -> Result:
    """Run both laws on manipulability alone, and on the range potential below a reach."""
    rng = np.random.default_rng(settings.seed)
    starts, goals, steps = (10, 2, 100) if settings.quick else (_STARTS, _GOALS, _HOLDING_STEPS)
    conditioned = _condition(rng, starts)
    held = []
    for done, hold in enumerate(_hold(rng, goals, steps), start=1):
        held.append(hold)
        settings.progress(done, goals)
    quantities = (*_growths(conditioned), *_errors(held))
    return Result(quantities, (_growth_chart(conditioned), _error_chart(held)), _NOTES)


# Model: with the gradient J of a potential phi as one row, and J^# = J^T / (J J^T), the printed law
# is
#     dq = -kappa J^# phi              for one controller,
#     dq = dq_1 + (I - J_1^# J_1) dq_2   with a subordinate one.
# It is Newton's step towards phi = 0 and presumes that the least value of phi is 0. Manipulability
# has no such value: where its gradient vanishes, the step phi / |J| grows without bound. A position
# that is reached has the residual 0, so that J_1 = 0 and the nullspace is everything. The
# subordinate controller then moves the hand away from its goal. Our law keeps a row for each
# coordinate of the residual, which stays in force at the goal.
class _Evaluation(NamedTuple):
    """Potential in k task coordinates: residual (k,), coordinates per joint (k, n), step (k,)."""

    phi: float
    residual: Floats
    jacobian: Floats
    step: Floats


def _evaluate(
    potential: Potential, value: Floats, reference: Floats, jacobian: Floats
) -> _Evaluation:
    """Evaluate a potential of a value (m,), whose Jacobian by the joints has shape (m, n)."""
    phi, residual, slope = potential.evaluate(value, reference, len(jacobian))
    rows = slope @ jacobian
    if potential.rule == Rule.DESCENT:
        return _Evaluation(phi, residual, rows, -np.square(rows).sum(axis=1))
    return _Evaluation(phi, residual, rows, residual / 2)


@dataclass(frozen=True)
class _Curves:
    """Curves from one start under both laws, step by step."""

    printed: Floats
    ours: Floats


def _condition(rng: np.random.Generator, starts: int) -> list[_Curves]:
    """Return manipulability, m^2, while it alone moves the planar arm."""
    potential = manipulability_potential(2, len(_LINKS))
    law = Law(np.full(3, -np.inf), np.full(3, np.inf), _SETTINGS)

    def evaluate(q: Floats) -> _Evaluation:
        jacobian, curvature = _planar(q)
        rows = curvature.reshape(jacobian.size, len(q))
        return _evaluate(potential, jacobian.ravel(), np.zeros(0), rows)

    def printed(q: Floats) -> Floats:
        evaluation = evaluate(q)
        return -_inverse(evaluation.jacobian[0]) * evaluation.phi

    def ours(q: Floats) -> Floats:
        evaluation = evaluate(q)
        return law.solve([Level("condition", evaluation.jacobian, evaluation.step)], q).displacement

    # The potential is the negative manipulability.
    def curve(q: Floats, move: Move, steps: int) -> Floats:
        return np.array([-evaluate(at).phi for at in _path(q, move, steps)])

    return [
        _Curves(curve(q, printed, _PRINTED_STEPS), curve(q, ours, _DESCENT_STEPS))
        for q in rng.uniform(-np.pi, np.pi, (starts, len(_LINKS)))
    ]


def _hold(rng: np.random.Generator, goals: int, steps: int) -> Iterator[_Curves]:
    """Yield the hand's distance from its goal, m, with the range potential below the reach."""
    arm = _Arm()
    law = Law(arm.lower, arm.upper, _SETTINGS)

    def printed(q: Floats, goal: Floats) -> Floats:
        reach, centre = arm.reach(q, goal), arm.centre(q)
        first, second = -reach.residual @ reach.jacobian, -centre.residual @ centre.jacobian
        free = np.eye(len(q)) - np.outer(_inverse(first), first)
        return -_inverse(first) * reach.phi - free @ _inverse(second) * _LOWER_GAIN * centre.phi

    def ours(q: Floats, goal: Floats) -> Floats:
        reach, centre = arm.reach(q, goal), arm.centre(q)
        levels = [
            Level("reach", reach.jacobian, reach.step),
            Level("centre", centre.jacobian, _LOWER_GAIN * centre.step),
        ]
        return law.solve(levels, q).displacement

    def curve(q: Floats, goal: Floats, law: Callable[[Floats, Floats], Floats]) -> Floats:
        path = _path(q, lambda at: law(at, goal), steps)
        return np.array([np.linalg.norm(goal - arm.hand(at)) for at in path])

    # The middle half of the limits, where no limit interferes.
    middle, quarter = (arm.lower + arm.upper) / 2, (arm.upper - arm.lower) / 4
    for q in rng.uniform(middle - quarter, middle + quarter, (goals, len(middle))):
        goal = arm.hand(q)
        yield _Curves(curve(q, goal, printed), curve(q, goal, ours))


class _Arm:
    """Kinematic model of one arm; the robot's other joints stay at 0."""

    def __init__(self) -> None:
        robot, urdf = shipped_robot(_ROBOT)
        self._kinematics = Kinematics(robot, urdf)
        self._tips = Tips(robot, self._kinematics)
        self._columns = self._kinematics.joints.of(_ARM)
        self.lower = self._kinematics.lower[self._columns]
        self.upper = self._kinematics.upper[self._columns]
        self._spring = spring_potential("position", 3)
        self._range = range_potential(self.lower, self.upper)

    def hand(self, q: Floats) -> Floats:
        """Return the position of the tip, m, shape (3,)."""
        return self._tip(q)[0]

    def reach(self, q: Floats, goal: Floats) -> _Evaluation:
        """Evaluate the spring between the hand and ``goal``."""
        position, jacobian = self._tip(q)
        return _evaluate(self._spring, position, goal, jacobian)

    def centre(self, q: Floats) -> _Evaluation:
        """Evaluate the range potential."""
        return _evaluate(self._range, q, np.zeros(0), np.eye(len(q)))

    def _tip(self, q: Floats) -> tuple[Floats, Floats]:
        """Return the position of the tip, m, shape (3,), and its Jacobian."""
        positions = np.zeros(len(self._kinematics.joints))
        positions[self._columns] = q
        self._kinematics.update(positions)
        tip = self._tips.point(_ARM)
        return tip.position, tip.jacobian[:3, self._columns]


def _path(q: Floats, move: Move, steps: int) -> list[Floats]:
    path = [q]
    for _ in range(steps):
        path.append(path[-1] + move(path[-1]))
    return path


def _inverse(row: Floats) -> Floats:
    """Return the pseudoinverse of one row; zero for a zero row."""
    square = float(row @ row)
    return row / square if square > 1e-24 else np.zeros_like(row)


def _planar(q: Floats) -> tuple[Floats, Floats]:
    """Return the Jacobian of the planar arm's tip, with joints about z, and its derivative."""
    angles = np.cumsum(q)
    links = _LINKS[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    # Vector from each joint to the tip; joint i moves the tip at right angles to it.
    carried = np.cumsum(links[::-1], axis=0)[::-1]
    jacobian = np.column_stack((-carried[:, 1], carried[:, 0])).T
    # Joint j rotates the vector of the outer one of joints i and j.
    outer = np.maximum.outer(np.arange(len(q)), np.arange(len(q)))
    curvature = -np.moveaxis(carried[outer], 2, 0)
    return jacobian, curvature


def _growths(starts: Sequence[_Curves]) -> Iterator[Quantity]:
    for law, curves in (
        (_PRINTED, [each.printed for each in starts]),
        (_OURS, [each.ours for each in starts]),
    ):
        grown = sum(float(curve[-1]) >= float(curve[0]) for curve in curves)
        yield percentage(
            _GROWS.named(law=law),
            grown,
            len(curves),
            note=f"mean {_mean(curves, 0):.3g} -> {_mean(curves, -1):.3g} m²",
        )


def _mean(curves: Sequence[Floats], step: int) -> float:
    return float(np.mean([curve[step] for curve in curves]))


def _errors(starts: Sequence[_Curves]) -> Iterator[Quantity]:
    for law, errors in (
        (_PRINTED, [1000 * float(each.printed[-1]) for each in starts]),
        (_OURS, [1000 * float(each.ours[-1]) for each in starts]),
    ):
        yield percentage(
            _KEEPS.named(law=law),
            sum(error <= 1000 * _HELD for error in errors),
            len(errors),
            note=f"mean {np.mean(errors):.2g} mm, {min(errors):.2g} to {max(errors):.2g} mm",
        )


def _growth_chart(starts: Sequence[_Curves]) -> Chart:
    curves = {
        "printed": np.mean([each.printed for each in starts], axis=0),
        "ours": np.mean([each.ours[: 2 * _PRINTED_STEPS + 1] for each in starts], axis=0),
    }
    name, title = "law-as-printed-manipulability", "Mean manipulability"
    return Chart(name, title, "step", "manipulability, m²", _lines(curves, 1))


def _error_chart(starts: Sequence[_Curves]) -> Chart:
    curves = {
        "printed": 1000 * np.mean([each.printed for each in starts], axis=0),
        "ours": 1000 * np.mean([each.ours for each in starts], axis=0),
    }
    name, title = "law-as-printed-priority", "Distance of the hand from a goal that it had reached"
    return Chart(name, title, "iteration", "mean distance, mm", _lines(curves, _POINT))


def _lines(curves: dict[str, Floats], every: int) -> tuple[Line, ...]:
    return tuple(
        Line(law, tuple(map(float, range(0, len(curve), every))), tuple(curve[::every].tolist()))
        for law, curve in curves.items()
    )
