"""Every registered potential: gradients, residuals and steps over random robots and postures."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from cbdsl.control.potential import Evaluation
from cbdsl.control.registry import IMPLEMENTATIONS, build
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.program.controller import Controller, Quiescence
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import TYPES, ResourceType, configuration
from tests.control.chain import Chain

GEOMETRIC = ("configuration", "position", "orientation", "pose")
CASES = [
    (potential.name, kind, axis)
    for potential in POTENTIALS.values()
    for kind in sorted(potential.accepts)
    for axis in ((None, "x", "y", "z") if kind in ("orientation", "pose") else (None,))
]


def controller(potential: str, kind: ResourceType, axis: str | None = None) -> Controller:
    feedback = Resource("feedback", kind, Origin.KINEMATICS, EffectorConfiguration("arm"), True)
    return Controller(
        "task", potential, feedback, None, feedback, (), (), False, 2.0, None, None,
        Quiescence(1e-3, 0.3, None), free_axis=axis,
    )  # fmt: skip


def measure(kind: str, chain: Chain, q: Floats, mix: Floats) -> Signal:
    """The signal of a type; those without geometry are smooth functions of the joints."""
    if kind in GEOMETRIC:
        return chain.signal(kind, q)
    angles = mix @ q
    return Signal(kind, np.sin(angles), np.cos(angles)[:, None] * mix)


def evaluations(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> Iterator[tuple[Callable[[Floats], Evaluation], Floats]]:
    """phi over the joints of random chains, and a random posture of each."""
    for _ in range(8):
        chain = Chain.random(int(rng.integers(3, 9)), rng)
        typed = configuration(chain.joints) if kind == "configuration" else TYPES[kind]
        law = build(
            controller(potential, typed, axis),
            -rng.uniform(2, 3, chain.joints),
            rng.uniform(2, 3, chain.joints),
        )
        mix = rng.normal(size=(typed.size, chain.joints))
        reference = measure(kind, chain, rng.uniform(-1.5, 1.5, chain.joints), mix).value

        def at(q: Floats) -> Evaluation:
            return law.evaluate(measure(kind, chain, q, mix), reference)  # noqa: B023

        yield at, rng.uniform(-1.5, 1.5, chain.joints)


def test_signatures_and_implementations_are_the_same_set() -> None:
    assert set(IMPLEMENTATIONS) == set(POTENTIALS)


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
        np.testing.assert_allclose(-here.jacobian.T @ here.residual, slopes, atol=1e-7)


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_small_steps_lower_phi_and_shapes_agree(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    for at, q in evaluations(potential, kind, axis, rng):
        here = at(q)
        assert here.jacobian.shape == (len(here.residual), len(q))
        assert here.step.shape == here.residual.shape
        downhill = here.jacobian.T @ here.step
        assert at(q + 1e-4 * downhill).phi < here.phi


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_known_minimum_is_where_the_residual_leads(
    potential: str, kind: str, axis: str | None, rng: np.random.Generator
) -> None:
    if not POTENTIALS[potential].zero_minimum:
        pytest.skip("its minimum is not known")
    reached = 0
    for at, q in evaluations(potential, kind, axis, rng):
        for _ in range(100):
            here = at(q)
            q = q + np.linalg.pinv(here.jacobian, rcond=1e-2) @ (0.3 * here.residual)
        reached += at(q).phi < 1e-12
    # Short chains do not reach every orientation by descent alone.
    assert reached >= 4


@pytest.mark.parametrize(("potential", "kind", "axis"), CASES)
def test_wrong_shapes_are_refused_by_name(potential: str, kind: str, axis: str | None) -> None:
    typed = configuration(4) if kind == "configuration" else TYPES[kind]
    law = build(controller(potential, typed, axis), -np.ones(4), np.ones(4))
    signal = Signal("left.thing", np.zeros(17), np.zeros((16, 4)))
    with pytest.raises(SignalError, match=r"left\.thing"):
        law.evaluate(signal, np.zeros(17))
