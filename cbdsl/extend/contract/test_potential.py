"""Contract of potentials: gradients, steps and rules over the joints of Dexter's right arm."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.api.shipped import shipped_robot
from cbdsl.control.potential import Potential, Rule, interpreted
from cbdsl.control.potential_registry import build
from cbdsl.control.setting import Setting
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller, Quiescence
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import TYPES, ResourceType, configuration

CASES = [
    pytest.param(name, kind, id=f"{name}-{kind}")
    for name in POTENTIALS
    if not POTENTIALS.registry.is_builtin(name) and not POTENTIALS[name].field
    for kind in sorted(POTENTIALS[name].accepts)
]
CASE = pytest.mark.parametrize(("name", "kind"), CASES)


class JointEvaluation(NamedTuple):
    """Potential by the joints: phi, residual (k,), and coordinates per joint (k, n)."""

    phi: float
    residual: Floats
    jacobian: Floats


class Arm:
    """Signals of a type, as functions of the joints of the right arm.

    Args:
        kind: Type of the signals; types without geometry are smooth functions of the joints.
        rng: Source of these functions.
    """

    def __init__(self, kind: ResourceType, rng: np.random.Generator) -> None:
        robot, urdf = shipped_robot("dexter")
        self._kinematics, self._kind = Kinematics(robot, urdf), kind
        tip = robot.effectors["right_arm"].tip
        assert tip is not None
        self._tip, self._link = tip, tip.link
        self._own = self._kinematics.joints.of("right_arm")
        self.joints = len(robot.joints("right_arm"))
        self._mix = rng.normal(size=(kind.size, self.joints))

    def signal(self, q: Floats) -> tuple[Floats, Floats]:
        """Return the value as a row of the signal table, and its Jacobian (rows, n)."""
        if self._kind.name == "configuration":
            return q, np.eye(self.joints)
        if self._kind.name not in ("position", "orientation", "pose"):
            angles = self._mix @ q
            return np.sin(angles), np.cos(angles)[:, None] * self._mix
        posture = np.zeros(len(self._kinematics.joints.names))
        posture[self._own] = q
        self._kinematics.update(posture)
        position, jacobian = self._kinematics.point(self._link, self._tip.offset)
        rotation = self._kinematics.frame(self._link).rotation
        value = np.concatenate([position, rotation.ravel()])
        rows = {"position": slice(0, 3), "orientation": slice(3, 6), "pose": slice(0, 6)}
        part = {"position": slice(0, 3), "orientation": slice(3, 12), "pose": slice(0, 12)}
        own = jacobian[:, self._own]
        return value[part[self._kind.name]].copy(), own[rows[self._kind.name]].copy()


def _built(name: str, kind: ResourceType, arm: Arm) -> Potential:
    feedback = Resource("feedback", kind, Origin.KINEMATICS, EffectorConfiguration("arm"), True)
    joints = tuple(f"joint {i}" for i in range(arm.joints))
    controller = Controller(
        "task", name, feedback, None, feedback, joints, (), False, 2.0, None, None,
        Quiescence(1e-3, 0.3, None),
    )  # fmt: skip
    value, jacobian = arm.signal(np.zeros(arm.joints))
    limits = np.full(arm.joints, 3.0)
    return build(controller, Setting(-limits, limits, len(value), len(jacobian)))


def _evaluations(
    name: str, kind: str, *, in_python: bool = False
) -> Iterator[tuple[Potential, Callable[[Floats], JointEvaluation], Floats]]:
    """Yield a potential, its evaluation at a posture, and a random posture."""
    known, rng = POTENTIALS[name], np.random.default_rng(7)
    for _ in range(6):
        typed = configuration(7) if kind == "configuration" else TYPES[kind]
        arm = Arm(typed.times(known.factors or 1), rng)
        law = _built(name, typed.times(known.factors or 1), arm)
        goal = arm.signal(rng.uniform(-1.2, 1.2, arm.joints))[0]
        reference = goal if known.reference else np.zeros(0)
        function = interpreted(law.function) if in_python else law.function

        def at(q: Floats) -> JointEvaluation:
            value, jacobian = arm.signal(q)  # noqa: B023
            residual, slope = np.zeros(law.size), np.zeros((law.size, len(jacobian)))  # noqa: B023
            phi = function(value, reference, law.parameters, residual, slope)  # noqa: B023
            slope = np.eye(law.size) if law.identity else slope  # noqa: B023
            return JointEvaluation(float(phi), residual, slope @ jacobian)

        yield law, at, rng.uniform(-1.2, 1.2, arm.joints)


@CASE
def test_gradient_equals_finite_differences(name: str, kind: str) -> None:
    for law, at, q in _evaluations(name, kind):
        here, small = at(q), 1e-6
        slopes = [
            (at(q + small * unit).phi - at(q - small * unit).phi) / (2 * small)
            for unit in np.eye(len(q))
        ]
        residual = law.rule == Rule.RESIDUAL
        gradient = -here.jacobian.T @ here.residual if residual else here.jacobian[0]
        np.testing.assert_allclose(gradient, slopes, rtol=1e-6, atol=1e-7)


@CASE
def test_rule_of_a_potential_agrees_with_its_entry(name: str, kind: str) -> None:
    known = POTENTIALS[name]
    downhill = Rule.TO_ZERO if known.zero_minimum else Rule.DESCENT
    for law, _, _ in _evaluations(name, kind):
        assert law.rule == (Rule.RESIDUAL if known.residual else downhill)
        assert not (known.scalar and law.size != 1)


@CASE
def test_small_step_lowers_phi_or_is_at_its_minimum(name: str, kind: str) -> None:
    for law, at, q in _evaluations(name, kind):
        here = at(q)
        # Along the gradient phi falls for every rule.
        residual = law.rule == Rule.RESIDUAL
        downhill = here.jacobian.T @ (here.residual if residual else -np.ones(1))
        assert at(q + 1e-4 * downhill).phi < here.phi or here.phi == 0.0


@CASE
def test_compiled_potential_equals_the_interpreted_one(name: str, kind: str) -> None:
    """Interpreted, a function that writes out of its arrays' bounds raises an error."""
    pairs = zip(_evaluations(name, kind), _evaluations(name, kind, in_python=True), strict=True)
    for (_, compiled, q), (_, plain, _) in pairs:
        for one, other in zip(compiled(q), plain(q), strict=True):
            np.testing.assert_allclose(np.array(one), np.array(other), rtol=1e-12, atol=1e-14)
