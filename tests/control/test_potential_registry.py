"""Every registered potential: gradients, residuals and steps over random robots and postures."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from cbdsl.control.potential import Potential, Rule
from cbdsl.control.potential_registry import build
from cbdsl.control.potentials.spring import spring
from cbdsl.control.setting import Setting
from cbdsl.kinematics.kinematics import Frame
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller, Quiescence
from cbdsl.sensing.vision.regions.camera import heading, sighting_jacobian
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import TYPES, ResourceType, configuration
from tests.control.chain import Chain
from tests.control.evaluation import Evaluation, Signal, evaluate, gradient

GEOMETRIC = ("configuration", "position", "orientation", "pose")
CASES = [
    (potential.name, kind, axis)
    for potential in POTENTIALS.values()
    if not potential.field  # potentials solved on a grid have tests of their own
    for kind in sorted(potential.accepts)
    for axis in ((None, "x", "y", "z") if kind in ("orientation", "pose") else (None,))
]
# Two cameras that look along the world's x axis at chains that begin a metre ahead.
CAMERAS = tuple(Frame(np.array([-1.0, side, 0.0]), np.eye(3)) for side in (0.2, -0.2))


def feedback_type(potential: PotentialType, kind: str, joints: int) -> ResourceType:
    typed = configuration(joints) if kind == "configuration" else TYPES[kind]
    return typed.times(potential.factors or 1)


def controller(potential: str, kind: ResourceType) -> Controller:
    feedback = Resource("feedback", kind, Origin.KINEMATICS, EffectorConfiguration("arm"), True)
    joints = tuple(f"joint {i}" for i in range(kind.size if kind.name == "configuration" else 0))
    return Controller(
        "task", potential, feedback, None, feedback, joints, (), False, 2.0, None, None,
        Quiescence(1e-3, 0.3, None),
    )  # fmt: skip


def made(
    potential: str, kind: ResourceType, joints: int, axis: str | None, rng: np.random.Generator
) -> Potential:
    """Return the registered potential for the tip of a chain, or a spring with a free axis."""
    rows = 3 * joints if potential == "manipulability" else kind.size
    components = {"orientation": 9, "pose": 12}.get(kind.name, rows)
    limits = -rng.uniform(2, 3, joints), rng.uniform(2, 3, joints)
    if axis is not None:
        return spring(kind.name, kind.size, axis)
    return build(controller(potential, kind), Setting(*limits, components, rows, CAMERAS))


def measure(potential: str, kind: ResourceType, chain: Chain, q: Floats, mix: Floats) -> Signal:
    """Return the signal of a type; types without geometry are smooth functions of the joints."""
    if potential == "manipulability":
        return bent(chain, q)
    if potential == "localizability":
        return sighting(chain.signal("position", q))
    if kind.name in GEOMETRIC:
        return chain.signal(kind.name, q)
    angles = mix @ q
    return Signal(np.sin(angles), np.cos(angles)[:, None] * mix)


def bent(chain: Chain, q: Floats) -> Signal:
    """Return the Jacobian of the chain's tip, row by row, and its derivative."""
    jacobian, curvature = curved(chain, q)
    return manipulator(jacobian, curvature)


def manipulator(jacobian: Floats, curvature: Floats) -> Signal:
    """Return a Jacobian (m, n) as a signal, with its curvature (m, n, n) as Jacobian."""
    return Signal(jacobian.ravel(), curvature.reshape(jacobian.size, -1))


def curved(chain: Chain, q: Floats) -> tuple[Floats, Floats]:
    """Return the Jacobian of a tip's position (3, n), and its derivative by the joints (3, n, n).

    For two joints, the joint nearer to the base turns the tip's velocity by the other.
    """
    linear, angular = np.split(chain.pose(q)[2], 2)
    turned = np.cross(angular.T[:, None], linear.T[None]).transpose(2, 0, 1)
    inner_first = np.triu(np.ones((chain.joints, chain.joints), dtype=bool))
    curvature = np.where(inner_first, turned, turned.transpose(0, 2, 1))
    return linear, curvature


def sighting(tip: Signal) -> Signal:
    """Return the headings to a tip in both cameras."""
    seen = [camera.rotation.T @ (tip.value - camera.position) for camera in CAMERAS]
    return Signal(
        np.concatenate([heading(point) for point in seen]),
        np.vstack(
            [
                sighting_jacobian(point) @ camera.rotation.T @ tip.jacobian
                for point, camera in zip(seen, CAMERAS, strict=True)
            ]
        ),
    )


def evaluations(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> Iterator[tuple[Callable[[Floats], Evaluation], Floats]]:
    """Yield phi over the joints of random chains, and a random posture of each."""
    for _ in range(8):
        chain = Chain.random(int(rng.integers(3, 9)), rng)
        typed = feedback_type(POTENTIALS[potential], kind, chain.joints)
        law = made(potential, typed, chain.joints, axis, rng)
        mix = rng.normal(size=(typed.size, chain.joints))
        goal = rng.uniform(-1.5, 1.5, chain.joints)
        reference = None
        if POTENTIALS[potential].reference:
            reference = measure(potential, typed, chain, goal, mix).value

        def at(q: Floats) -> Evaluation:
            signal = measure(potential, typed, chain, q, mix)  # noqa: B023
            found = evaluate(law, signal, reference)  # noqa: B023
            assert found.residual.shape == (law.size,)  # noqa: B023
            return found

        yield at, rng.uniform(-1.5, 1.5, chain.joints)


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_gradient_equals_finite_differences(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    for at, q in evaluations(potential, kind, axis, rng):
        here, small = at(q), 1e-6
        slopes = [
            (at(q + small * unit).phi - at(q - small * unit).phi) / (2 * small)
            for unit in np.eye(len(q))
        ]
        np.testing.assert_allclose(gradient(potential, here), slopes, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_compiled_potential_equals_the_interpreted_one(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    """Interpreted, a function that writes out of its arrays' bounds raises an error."""
    chain = Chain.random(5, rng)
    typed = feedback_type(POTENTIALS[potential], kind, chain.joints)
    law, mix = made(potential, typed, chain.joints, axis, rng), rng.normal(size=(typed.size, 5))
    for q, goal in rng.uniform(-1.5, 1.5, (3, 2, 5)):
        here, there = (measure(potential, typed, chain, each, mix) for each in (q, goal))
        reference = there.value if POTENTIALS[potential].reference else None
        found = (evaluate(law, here, reference, in_python=each) for each in (False, True))
        for one, other in zip(*found, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_rule_of_a_potential_agrees_with_its_entry(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    known = POTENTIALS[potential]
    law = made(potential, feedback_type(known, kind, 5), 5, axis, rng)
    downhill = Rule.TO_ZERO if known.zero_minimum else Rule.DESCENT
    assert law.rule == (Rule.RESIDUAL if known.residual else downhill)
    assert not (known.scalar and law.size != 1)


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_small_steps_lower_phi_and_shapes_agree(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    for at, q in evaluations(potential, kind, axis, rng):
        here = at(q)
        assert here.jacobian.shape == (len(here.residual), len(q))
        assert here.step.shape == here.residual.shape
        downhill = here.jacobian.T @ here.step
        # At its minimum there is nothing to lower.
        assert at(q + 1e-4 * downhill).phi < here.phi or here.phi == 0.0


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_known_minimum_is_where_the_residual_leads(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    if not (POTENTIALS[potential].residual and POTENTIALS[potential].zero_minimum):
        pytest.skip("it has no residual, or one that leads elsewhere")
    reached = 0
    for at, q in evaluations(potential, kind, axis, rng):
        for _ in range(100):
            here = at(q)
            q = q + np.linalg.pinv(here.jacobian, rcond=1e-2) @ (0.3 * here.residual)
        reached += at(q).phi < 1e-12
    # Short chains do not reach every orientation by descent alone.
    assert reached >= 4
