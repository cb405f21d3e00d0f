"""Hessians of task coordinates: by second differences of the springs of shipped robots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest

from cbdsl.control.hessian import has_hessian, write_hessian
from cbdsl.control.plan import ControllerPlan, SlotForm
from cbdsl.control.potential import Potential
from cbdsl.control.potentials.spring import along_axes, spring
from cbdsl.control.slot import SLOT
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.rotation import exp
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import (
    CONFIGURATION,
    CONTACT,
    HEADING,
    MIXTURE,
    NORMAL_FORCES,
    ROW,
    TIP,
    WRITTEN,
)
from cbdsl.types.resource import Centroid, Separation, Source, Tip
from cbdsl.yaml_text.library import Library, shipped

LIBRARY = Library(shipped())
ROBOTS = sorted(path.stem for path in (shipped() / "robots").glob("*.yaml"))
STEP, APART = 1e-3, 0.02  # rad; m or rad


class Case(NamedTuple):
    """A spring of a robot's tip: part of it, and the axis about which it may turn."""

    robot: str
    effector: str
    part: str
    spin: str | None = None


def document(robot: str) -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, robot), RobotDocument).document


def cases() -> Iterator[Case]:
    for name in ROBOTS:
        for effector, each in document(name).effectors.items():
            if each.tip is not None:
                yield Case(name, effector, "position")
                yield Case(name, effector, "pose")
                for spin in (None, "x", "y", "z"):
                    yield Case(name, effector, "orientation", spin)


class Spring:
    """A spring between a signal of a robot and a reference near it, in any posture."""

    def __init__(
        self, robot: str, source: Source, potential: Potential, kind: str, spin: int = -1
    ) -> None:
        path, model = LIBRARY.locate(RobotDocument, robot), document(robot)
        kinematics = Kinematics(model, path.parent / model.model)
        self.joints = len(kinematics.lower)
        self.signals, self.plan, self.kind = Signals(model, kinematics, ()), ControllerPlan(), kind
        self.potential = potential
        self.cells = [(hand, finger) for hand, each in model.load_cells.items() for finger in each]
        rows = self.signals.kinematic_rows
        bind = {Tip: rows.tip, Centroid: rows.centroid, Separation: rows.separation}
        self.feedback = bind[type(source)](source)
        size = len(self.signals.table.values(self.feedback))
        self.reference = self.signals.bind_written(size)
        self.plan.add(
            SlotForm(potential, np.ones(6), np.ones(3), self.feedback, self.reference, spin=spin)
        )
        self.place(np.zeros(self.joints))

    def place(self, q: Floats) -> tuple[Floats, Floats]:
        """Take a posture; returns value and Jacobian rows."""
        loads = {cell: np.zeros(6) for cell in self.cells}
        self.signals.update(Observation(0.0, q, np.zeros(self.joints), loads, {}))
        self.signals.refresh(self.signals.select([self.feedback]))
        table = self.signals.table
        return table.values(self.feedback).copy(), table.rows(self.feedback).copy()

    def evaluate(self, q: Floats) -> tuple[float, Floats, Floats]:
        """Return phi, the residual and the Jacobian of the task coordinates."""
        value, rows = self.place(q)
        reference = self.signals.table.values(self.reference)
        phi, residual, slope = self.potential.evaluate(value, reference, len(rows))
        return phi, residual, slope @ rows

    def hessian(self, q: Floats) -> Floats:
        self.place(q)
        size = self.potential.size
        hessian = np.full((size, self.joints, self.joints), np.nan)
        write_hessian(
            self.plan.slots[0], self.signals.arrays, self.plan.parameters, np.arange(self.joints),
            hessian,
        )  # fmt: skip
        return hessian


def displaced(value: Floats, kind: str, rng: np.random.Generator) -> Floats:
    """Return a slightly displaced value."""
    if kind == "orientation":
        return (exp(APART * rng.normal(size=3)) @ value.reshape(3, 3)).ravel()
    if kind == "pose":
        turned = exp(APART * rng.normal(size=3)) @ value[3:].reshape(3, 3)
        return np.concatenate((value[:3] + APART * rng.normal(size=3), turned.ravel()))
    return value + APART * rng.normal(size=len(value))


def check(it: Spring, rng: np.random.Generator) -> None:
    """Check that the second derivative of phi along a line is |J d|^2 - e . H[d, d]."""
    for _ in range(5):
        q = rng.uniform(-1.0, 1.0, it.joints)
        value, _ = it.place(q)
        apart = Reading(displaced(value, it.kind, rng), None, 0)
        it.signals.table.write(it.reference, apart)
        way = rng.normal(size=it.joints)
        phi, residual, rows = it.evaluate(q)
        curved = residual @ np.einsum("ijk,j,k->i", it.hessian(q), way, way)
        both = it.evaluate(q + STEP * way)[0] + it.evaluate(q - STEP * way)[0]
        bend = (both - 2 * phi) / STEP**2
        linear = float(np.sum((rows @ way) ** 2))
        # The logarithm of a rotation bends by a twelfth of the square of its angle.
        rest = residual @ residual * linear + 1e-4 * linear + 1e-6
        assert bend == pytest.approx(linear - curved, abs=rest)


@pytest.mark.parametrize("case", list(cases()), ids=str)
def test_hessian_of_a_tip_is_the_second_derivative_of_its_spring(
    case: Case, rng: np.random.Generator
) -> None:
    size = {"position": 3, "orientation": 3, "pose": 6}[case.part]
    spin = -1 if case.spin is None else "xyz".index(case.spin)
    potential = spring(case.part, size, case.spin)
    check(Spring(case.robot, Tip(case.effector, case.part), potential, case.part, spin), rng)


@pytest.mark.parametrize("source", [Centroid("arms"), Separation("arms"), Tip("arms", "position")])
def test_hessian_of_a_group_is_that_of_its_weighted_tips(
    source: Source, rng: np.random.Generator
) -> None:
    size = 6 if isinstance(source, Tip) else 3
    check(Spring("dexter", source, spring("position", size), "position"), rng)


def test_hessian_of_some_axes_is_that_of_these_rows(rng: np.random.Generator) -> None:
    source = Tip("right_arm", "position")
    check(Spring("dexter", source, along_axes([2, 0]), "position"), rng)


def test_hessian_of_a_carried_object_is_that_of_a_point_of_the_hand(
    rng: np.random.Generator,
) -> None:
    """Use a row without a chain of joints, with a Jacobian alone."""
    it = Spring("dexter", Tip("right_arm", "position"), spring("position", 3), "position")
    q = rng.uniform(-1.0, 1.0, it.joints)
    expected = it.hessian(q)
    value, rows = it.place(q)
    carried = it.signals.bind_written(3)
    it.signals.table.write(carried, Reading(value, rows, 1))
    it.plan.slots["feedback"], it.plan.slots["carried"] = carried, True
    hessian = np.full_like(expected, np.nan)
    arrays = it.signals.arrays
    write_hessian(it.plan.slots[0], arrays, it.plan.parameters, np.arange(it.joints), hessian)
    np.testing.assert_allclose(hessian, expected, atol=1e-12)


def test_hessian_leaves_joints_out_that_the_slot_does_not_move(rng: np.random.Generator) -> None:
    it = Spring("dexter", Tip("right_arm", "position"), spring("position", 3), "position")
    whole = it.hessian(rng.uniform(-1.0, 1.0, it.joints))
    columns = np.arange(it.joints)
    columns[::2] = -1
    part = np.full_like(whole, np.nan)
    write_hessian(it.plan.slots[0], it.signals.arrays, it.plan.parameters, columns, part)
    moved = columns >= 0
    np.testing.assert_array_equal(part, whole * np.outer(moved, moved))


@pytest.mark.parametrize(("kind", "carried", "bends"), [
    (TIP, False, True), (MIXTURE, False, True), (WRITTEN, True, True), (WRITTEN, False, False),
    (HEADING, False, True), (CONTACT, False, True), (CONFIGURATION, False, False),
    (NORMAL_FORCES, False, False),
])  # fmt: skip
def test_has_hessian_signals_that_bend_and_carried_objects_alone(
    kind: int, carried: bool, bends: bool
) -> None:
    table, slots = np.zeros(1, ROW), np.zeros(1, SLOT)
    table["kind"], slots["carried"] = kind, carried
    assert has_hessian.py_func(slots.view(np.recarray)[0], table.view(np.recarray)) is bends
