"""Every potential meets the conditions of a navigation function that it claims, and no others.

A claim is checked numerically on the domain it names; where none is made, a counterexample shows
why not (Koditschek and Rimon 1990; Section 3.1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.control.potentials.bound import bound
from cbdsl.control.potentials.localizability import seen_by
from cbdsl.control.potentials.look_at import look_at
from cbdsl.control.potentials.manipulability import of_jacobian
from cbdsl.control.potentials.range import between
from cbdsl.control.potentials.spring import spring
from cbdsl.control.signal import SignalError
from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.types.potential import POTENTIALS, Condition
from tests.control.chain import Chain
from tests.control.evaluation import Signal, evaluate, gradient
from tests.control.potentials.test_localizability import ahead, headings
from tests.control.test_potential_registry import bent, curved, feedback_type, manipulator

CONDITIONS = ("analytic", "polar", "admissible", "morse")
CAMERAS = ahead(0.35)


class Function(NamedTuple):
    """A potential as a function of its feedback, on the domain of its claims.

    Attributes:
        at: Function that returns phi and its gradient by ``move``'s displacements, or raises
        ``SignalError`` outside.
        draw: Function that samples a point of the domain.
        bound: Bound of the gradient's norm.
        move: Function that displaces a point by a vector.
    """

    at: Callable[[Floats], tuple[float, Floats]]
    draw: Callable[[], Floats]
    bound: float
    move: Callable[[Floats, Floats], Floats] = np.add


def springs(rng: np.random.Generator) -> Iterator[Function]:
    """Yield springs on every type; errors are at most ``longest``, turns less than half a turn."""
    longest = 3.0
    for kind in sorted(POTENTIALS["spring"].accepts):
        typed = feedback_type(POTENTIALS["spring"], kind, 5)
        law = spring(kind, typed.size)

        def move(value: Floats, by: Floats) -> Floats:
            if value.shape == (4, 4):
                shifted = value.copy()
                shifted[:3, :3], shifted[:3, 3] = exp(by[3:]) @ value[:3, :3], value[:3, 3] + by[:3]
                return shifted
            return exp(by) @ value if value.shape == (3, 3) else value + by

        origin = {"orientation": np.eye(3), "pose": np.eye(4)}.get(kind, np.zeros(typed.size))
        reference = move(origin, rng.uniform(-1, 1, typed.size))

        def at(value: Floats) -> tuple[float, Floats]:
            identity = np.eye(typed.size)  # noqa: B023
            evaluation = evaluate(law, Signal(value, identity), reference)  # noqa: B023
            return evaluation.phi, gradient("spring", evaluation)

        def draw() -> Floats:
            error = rng.normal(size=typed.size)  # noqa: B023
            length = longest * rng.uniform()
            return move(reference, length * error / np.linalg.norm(error))  # noqa: B023

        yield Function(at, draw, longest * (1 + 1e-9), move)


def ranges(rng: np.random.Generator) -> Iterator[Function]:
    lower, upper = -rng.uniform(0.5, 3, 6), rng.uniform(0.5, 3, 6)
    law = between(lower, upper)

    def at(q: Floats) -> tuple[float, Floats]:
        if ((q < lower) | (q > upper)).any():
            raise SignalError("beyond a limit")
        evaluation = evaluate(law, Signal(q, np.eye(6)))
        return evaluation.phi, gradient("range", evaluation)

    inner = 0.05 * (upper - lower)
    yield Function(
        at,
        lambda: rng.uniform(lower + inner, upper - inner),
        float(np.linalg.norm(np.pi / (upper - lower))),
    )


def chains(rng: np.random.Generator) -> Iterator[Function]:
    """Yield manipulabilities with postures at a distance from singularities."""
    for joints in (4, 7):
        chain = Chain.random(joints, rng)

        def at(q: Floats) -> tuple[float, Floats]:
            evaluation = evaluate(of_jacobian(3, len(q)), bent(chain, q))  # noqa: B023
            return evaluation.phi, evaluation.jacobian[0]

        scale = max(-at(q)[0] for q in rng.uniform(-3, 3, (30, joints)))

        def draw() -> Floats:
            while True:
                q = rng.uniform(-3, 3, joints)  # noqa: B023
                if -at(q)[0] > 0.1 * scale:  # noqa: B023
                    return q

        # No entry of J, and no change of one per joint, is longer than the chain, L; w is the
        # root of a sum of squared 3 x 3 minors of J.
        length = np.linalg.norm(chain.links, axis=1).sum()
        yield Function(at, draw, 3 * np.sqrt(joints) * joints**1.5 * length**3)


def sights(rng: np.random.Generator) -> Iterator[Function]:
    """Yield lines of sight that nearly meet, ahead of the cameras."""

    def at(angles: Floats) -> tuple[float, Floats]:
        evaluation = evaluate(seen_by(CAMERAS), Signal(angles, np.eye(4)))
        if math.isnan(evaluation.phi):
            raise SignalError("the lines of sight do not meet")
        return evaluation.phi, evaluation.jacobian[0]

    def draw() -> Floats:
        point = rng.uniform([0.3, -0.3, -0.3], [1.2, 0.3, 0.3])
        return headings(CAMERAS, point) + rng.normal(size=4) * 0.005

    yield Function(at, draw, np.inf)


def moved(pose: Floats, by: Floats) -> Floats:
    """Return a pose (4, 4) displaced, and turned about itself."""
    shifted = pose.copy()
    shifted[:3, :3], shifted[:3, 3] = exp(by[3:]) @ pose[:3, :3], pose[:3, 3] + by[:3]
    return shifted


def view(pose: Floats, point: Floats) -> tuple[float, Floats]:
    """Evaluate ``look_at`` for a tip's z axis and a point."""
    evaluation = evaluate(look_at("z"), Signal(pose, np.eye(6)), point)
    if math.isnan(evaluation.phi):
        raise SignalError("the point is where the tip is")
    return evaluation.phi, gradient("look_at", evaluation)


def views(rng: np.random.Generator) -> Iterator[Function]:
    """Yield views by tips at a distance from the point, turned from it by less than half a turn."""
    point = rng.uniform(-1, 1, 3)

    def draw() -> Floats:
        while True:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = exp(rng.normal(size=3)), rng.uniform(-2, 2, 3)
            away = float(np.linalg.norm(point - pose[:3, 3]))
            if away > 0.3 and pose[:3, 2] @ (point - pose[:3, 3]) > -0.9 * away:
                return pose

    yield Function(lambda pose: view(pose, point), draw, np.inf, moved)


def one_sided(name: str, side: float, rng: np.random.Generator) -> Function:
    """Return a bound of three components, by errors of at most 2 on either side."""
    reference = rng.uniform(-1, 1, 3)

    def at(value: Floats) -> tuple[float, Floats]:
        evaluation = evaluate(bound((0, 1, 2), side), Signal(value, np.eye(3)), reference)
        return evaluation.phi, gradient(name, evaluation)

    def draw() -> Floats:
        return reference + rng.uniform(-2.0, 2.0, 3)

    return Function(at, draw, 2.0 * math.sqrt(3.0) * (1 + 1e-9))


def upper(rng: np.random.Generator) -> Iterator[Function]:
    yield one_sided("at_most", 1.0, rng)


def lower(rng: np.random.Generator) -> Iterator[Function]:
    yield one_sided("at_least", -1.0, rng)


FUNCTIONS: dict[str, Callable[[np.random.Generator], Iterator[Function]]] = {
    "spring": springs,
    "at_most": upper,
    "at_least": lower,
    "range": ranges,
    "manipulability": chains,
    "localizability": sights,
    "look_at": views,
}


def curvature(function: Function, point: Floats, direction: Floats, small: float) -> float:
    """Return the gradient's slope along a direction, by differences."""
    ahead, behind = (
        function.at(function.move(point, way * direction))[1] for way in (small, -small)
    )
    return float((ahead - behind) @ direction) / (2 * small)


def hessian(function: Function, point: Floats) -> Floats:
    size, small = len(function.at(point)[1]), 1e-5
    rows = [
        function.at(function.move(point, d))[1] - function.at(function.move(point, -d))[1]
        for d in small * np.eye(size)
    ]
    matrix = np.array(rows) / (2 * small)
    return (matrix + matrix.T) / 2


def descend(function: Function, point: Floats) -> Floats:
    """Descend the gradient, in steps that lower phi, to its zero."""
    for _ in range(400):
        phi, slope = function.at(point)
        share = 4.0
        while share > 1e-9:
            share /= 2
            try:
                there = function.move(point, -share * slope)
                if function.at(there)[0] <= phi - 0.3 * share * (slope @ slope):
                    break
            except SignalError:
                continue
        if share <= 1e-9 or np.linalg.norm(slope) < 1e-7:
            break
        point = there
    return point


def critical(function: Function, point: Floats) -> Floats | None:
    """Search for a vanishing gradient by Newton's method; return its end if it is in the domain."""
    try:
        for _ in range(30):
            slope = function.at(point)[1]
            if np.linalg.norm(slope) < 1e-9:
                return point
            step = np.linalg.lstsq(hessian(function, point), slope, rcond=None)[0]
            point = function.move(point, -step * min(1.0, 0.5 / np.linalg.norm(step)))
    except SignalError:
        pass
    return None


def is_analytic(function: Function, rng: np.random.Generator) -> bool:
    """Return True if differences of phi give its gradient, and those of the gradient converge."""
    smooth = True
    for _ in range(10):
        point = function.draw()
        slope = function.at(point)[1]
        direction = rng.normal(size=len(slope))
        direction /= np.linalg.norm(direction)
        smooth &= converges(function, point, direction)
        small = 1e-6 * direction
        rise = function.at(function.move(point, small))[0]
        rise -= function.at(function.move(point, -small))[0]
        smooth &= bool(abs(rise / 2e-6 - slope @ direction) < 1e-6 * (1 + np.linalg.norm(slope)))
    return smooth


def converges(function: Function, point: Floats, direction: Floats) -> bool:
    """Return True if halved differences of the gradient halve their error, or better."""
    a, b, c = (curvature(function, point, direction, h) for h in (4e-3, 2e-3, 1e-3))
    return abs(b - c) <= 0.5 * abs(a - b) + 1e-6 * (1 + abs(c))


def is_polar(function: Function, rng: np.random.Generator) -> bool:
    """Return True if all descents and all searches for a critical point end in one point."""
    ends = [descend(function, function.draw()) for _ in range(8)]
    found = [critical(function, function.draw()) for _ in range(8)]
    points = ends + [point for point in found if point is not None]
    return all(np.allclose(point, points[0], atol=1e-5) for point in points)


def is_admissible(function: Function, rng: np.random.Generator) -> bool:
    """Return True if no gradient is longer than the bound."""
    largest = max(np.linalg.norm(function.at(function.draw())[1]) for _ in range(100))
    return bool(largest <= function.bound < np.inf)


def is_morse(function: Function, rng: np.random.Generator) -> bool:
    """Return True if the Hessian is regular at the ends of descents."""
    for _ in range(3):
        values = np.abs(np.linalg.eigvalsh(hessian(function, descend(function, function.draw()))))
        if values.min() < 1e-3 * values.max():
            return False
    return True


CHECKS = {
    "analytic": is_analytic,
    "polar": is_polar,
    "admissible": is_admissible,
    "morse": is_morse,
}
CLAIMS = [
    pytest.param(potential, condition, id=f"{potential}-{condition}")
    for potential in FUNCTIONS
    for condition in CONDITIONS
    if getattr(POTENTIALS[potential].navigation, condition) is Condition.MET
]


def test_every_potential_without_a_grid_has_a_test_function() -> None:
    on_grids = {name for name, potential in POTENTIALS.items() if potential.field}
    own = {name for name in POTENTIALS if POTENTIALS.registry.is_builtin(name)}
    assert set(FUNCTIONS) == own - on_grids


@pytest.mark.parametrize(("potential", "condition"), CLAIMS)
def test_claimed_conditions_of_a_potential_hold(
    potential: str, condition: str, rng: np.random.Generator
) -> None:
    functions = list(FUNCTIONS[potential](rng))
    assert functions
    for function in functions:
        assert CHECKS[condition](function, rng)


# Counterexamples.


def flat(chain: Chain, coupling: Floats) -> Callable[[Floats], tuple[float, Floats]]:
    """Return the manipulability in the plane of a chain whose joints follow actuated ones."""

    def at(q: Floats) -> tuple[float, Floats]:
        jacobian, curvature = curved(chain, coupling @ q)
        rows, change = jacobian[:2] @ coupling, coupling.T @ curvature[:2] @ coupling
        evaluation = evaluate(of_jacobian(*rows.shape), manipulator(rows, change))
        return evaluation.phi, evaluation.jacobian[0]

    return at


def two_links(elbow: tuple[float, float], rng: np.random.Generator) -> Function:
    """Return a function of the elbow alone; the shoulder makes no difference."""
    at = flat(Chain.planar(2), np.eye(2))

    def of_elbow(angle: Floats) -> tuple[float, Floats]:
        phi, slope = at(np.array([0.0, angle[0]]))
        return phi, slope[1:]

    return Function(of_elbow, lambda: rng.uniform(*elbow, 1), np.inf)


def manipulability_polar(rng: np.random.Generator) -> None:
    """Find one optimum for an elbow that bends one way, and two for one that bends both ways."""
    assert is_polar(two_links((0.1, 3.0), rng), rng)
    assert not is_polar(two_links((-3.0, 3.0), rng), rng)


def manipulability_morse(rng: np.random.Generator) -> None:
    """Ignore a joint that carries the whole chain, unless others follow it."""
    free = Function(flat(Chain.planar(3), np.eye(3)), lambda: rng.uniform(0.4, 1.4, 3), np.inf)
    assert not is_morse(free, rng)
    coupling = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
    coupled = Function(flat(Chain.planar(3), coupling), lambda: rng.uniform(0.4, 1.4, 2), np.inf)
    assert is_morse(coupled, rng)


def at_point(point: Floats) -> tuple[float, Floats]:
    """Return the localizability as a function of the seen point."""
    phi = evaluate(seen_by(CAMERAS), Signal(headings(CAMERAS, point), np.eye(4))).phi
    return phi, np.array([slope_along(point, axis) for axis in np.eye(3)])


def slope_along(point: Floats, axis: Floats) -> float:
    small = 1e-6
    ahead, behind = (
        evaluate(seen_by(CAMERAS), Signal(headings(CAMERAS, point + way * axis), np.eye(4))).phi
        for way in (small, -small)
    )
    return (ahead - behind) / (2 * small)


SADDLE = np.array([0.35 / np.sqrt(12), 0.0, 0.0])


def localizability_polar(rng: np.random.Generator) -> None:
    """Fall to 0 towards either camera, with a saddle between them."""
    np.testing.assert_allclose(at_point(SADDLE)[1], 0.0, atol=1e-8)
    for camera in CAMERAS:
        way = np.linspace(SADDLE, camera.position + np.array([1e-4, 0.0, 0.0]), 30)
        phis = [at_point(point)[0] for point in way]
        assert (np.diff(phis) < 0).all()
        assert phis[-1] < 1e-3 * phis[0]


def localizability_admissible(rng: np.random.Generator) -> None:
    """Show a gradient that grows with the distance without bound."""
    slopes = [np.linalg.norm(at_point(np.array([depth, 0.0, 0.0]))[1]) for depth in (1, 10, 100)]
    assert slopes[1] > 50 * slopes[0]
    assert slopes[2] > 50 * slopes[1]


def localizability_morse(rng: np.random.Generator) -> None:
    """Show a saddle that is a circle around the baseline."""
    for angle in rng.uniform(-1, 1, 5):
        turned = SADDLE[0] * np.array([np.cos(angle), 0.0, np.sin(angle)])
        np.testing.assert_allclose(at_point(turned)[1], 0.0, atol=1e-7)


def looking_along(line: Floats) -> Floats:
    """Return a pose at the origin whose z axis points along a vector."""
    pose, z = np.eye(4), line / np.linalg.norm(line)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    pose[:3, :3] = np.stack((x, np.cross(z, x), z), axis=1)
    return pose


def look_at_polar(rng: np.random.Generator) -> None:
    """Turn tips to a point from anywhere."""
    point = np.array([1.0, 0.2, 0.3])
    for share in (0.0, 0.5, 2.0):
        pose = looking_along(point)
        pose[:3, 3] = -share * point
        phi, slope = view(pose, point)
        assert phi < 1e-20
        np.testing.assert_allclose(slope, 0.0, atol=1e-9)


def look_at_admissible(rng: np.random.Generator) -> None:
    """Show a gradient that grows without bound as the point comes near."""
    line = np.array([1.0, 0.0, 1.0])
    slopes = [np.linalg.norm(view(np.eye(4), line * size)[1]) for size in (1, 0.1, 0.01)]
    assert slopes[1] > 5 * slopes[0]
    assert slopes[2] > 5 * slopes[1]


def look_at_morse(rng: np.random.Generator) -> None:
    """Turn the tip about the line of sight, and move it along that line."""
    point = np.array([1.0, 0.2, 0.3])
    function = Function(lambda pose: view(pose, point), lambda: np.eye(4), np.inf, moved)
    values = np.linalg.eigvalsh(hessian(function, looking_along(point)))
    assert (np.abs(values) < 1e-6).sum() == 4


def bound_analytic(rng: np.random.Generator) -> None:
    """Show a second derivative of 1 beyond the bound, and of 0 beside it."""
    for side in (1.0, -1.0):
        law, error = bound((0,), side), np.array([0.1])
        beyond, beside = (
            evaluate(law, Signal(way * side * error, np.eye(1)), np.zeros(1)) for way in (1.0, -1.0)
        )
        assert beyond.phi == pytest.approx(0.005) and beside.phi == 0.0


def bound_minima(rng: np.random.Generator) -> None:
    """Show two minima, and between them no curvature."""
    for function, side in ((next(upper(rng)), 1.0), (next(lower(rng)), -1.0)):
        for size in (5.0, 6.0):
            point = np.full(3, -side * size)
            phi, slope = function.at(point)
            assert phi == 0.0 and not slope.any()
            assert not hessian(function, point).any()


COUNTEREXAMPLES: dict[tuple[str, str], Callable[[np.random.Generator], None]] = {
    **{
        (name, condition): bound_analytic if condition == "analytic" else bound_minima
        for name in ("at_most", "at_least")
        for condition in ("analytic", "polar", "morse")
    },
    ("manipulability", "polar"): manipulability_polar,
    ("manipulability", "morse"): manipulability_morse,
    ("localizability", "polar"): localizability_polar,
    ("localizability", "admissible"): localizability_admissible,
    ("localizability", "morse"): localizability_morse,
    ("look_at", "polar"): look_at_polar,
    ("look_at", "admissible"): look_at_admissible,
    ("look_at", "morse"): look_at_morse,
}
UNCLAIMED = [
    pytest.param(potential, condition, id=f"{potential}-{condition}")
    for potential in FUNCTIONS
    for condition in CONDITIONS
    if getattr(POTENTIALS[potential].navigation, condition) is not Condition.MET
]


@pytest.mark.parametrize(("potential", "condition"), UNCLAIMED)
def test_unclaimed_condition_has_a_counterexample(
    potential: str, condition: str, rng: np.random.Generator
) -> None:
    COUNTEREXAMPLES[potential, condition](rng)


def test_manipulability_is_analytic_only_away_from_singularities() -> None:
    """There it has a kink, which is why the claim leaves them out."""
    at = flat(Chain.planar(2), np.eye(2))
    function = Function(at, lambda: np.zeros(2), np.inf)
    elbow = np.array([0.0, 1.0])
    assert converges(function, np.array([0.3, 1.0]), elbow)
    assert not converges(function, np.array([0.3, 1e-9]), elbow)


def test_rotations_by_half_a_turn_are_left_out() -> None:
    """There the shortest way back changes its side, and the gradient with it."""
    law = spring("orientation", 3)
    before, after = (
        evaluate(law, Signal(exp(np.array([0, 0, angle])), np.eye(3)), np.eye(3))
        for angle in (np.pi - 1e-6, np.pi + 1e-6)
    )
    assert before.phi == pytest.approx(after.phi)
    np.testing.assert_allclose(before.residual, -after.residual, atol=1e-5)
