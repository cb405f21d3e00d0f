"""From residuals to displacements: gain, speed, acceleration and braking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.conditions.rate import bounds_of, displace
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller, Quiescence
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import FORCE, HEADING, POSITION, ResourceType, configuration

TICK = 1 / 120


class Task:
    """A controller's task coordinates from tick to tick."""

    def __init__(self, controller: Controller, size: int) -> None:
        self.bounds, self.displacement = bounds_of(controller, TICK), np.zeros(size)

    def move(self, step: Floats, residual: Floats, rows: Floats) -> bool:
        return displace(step.copy(), residual, rows, 1.0, self.bounds, self.displacement)


def controller(kind: ResourceType, **settings: float | None) -> Controller:
    feedback = Resource("feedback", kind, Origin.KINEMATICS, EffectorConfiguration("arm"), True)
    plain = Controller(
        "reach", "spring", feedback, None, feedback, (), (), False, 8.0, None, None,
        Quiescence(1e-3, 0.3, None),
    )  # fmt: skip
    return replace(plain, **settings)


def task_of(controller: Controller, size: int | None = None) -> Task:
    scalar = POTENTIALS[controller.potential].scalar
    own = 1 if scalar else controller.feedback.type.size
    return Task(controller, size or own)


def rate(task: Task, residual: Floats, jacobian: Floats | None = None) -> Floats:
    """Return task displacement per second of a Newton step towards a residual of 0."""
    rows = np.eye(len(residual)) if jacobian is None else jacobian
    assert task.move(0.5 * residual, residual, rows)
    return task.displacement / TICK


def test_gain_times_newton_step() -> None:
    task, residual = task_of(controller(POSITION, gain=8.0)), np.array([0.1, 0.0, -0.2])
    moved = rate(task, residual, np.ones((3, 7)))
    np.testing.assert_allclose(moved, 4 * np.array([0.1, 0.0, -0.2]))


@given(st.lists(st.floats(-10, 10), min_size=3, max_size=3))
def test_speed_bounds_the_norm_and_keeps_the_direction(residual: list[float]) -> None:
    error = np.array(residual)
    moved = rate(task_of(controller(POSITION, speed=0.35)), error)
    assert np.linalg.norm(moved) <= 0.35 * (1 + 1e-12)
    np.testing.assert_allclose(np.cross(moved, error), 0, atol=1e-9)
    assert moved @ error >= 0


def test_speed_of_a_configuration_bounds_its_fastest_joint() -> None:
    task = task_of(controller(configuration(3), speed=0.8))
    np.testing.assert_allclose(rate(task, np.array([1.0, -2.0, 0.5])), [0.4, -0.8, 0.2])


@pytest.mark.parametrize("rows", [1, 3])
def test_speed_of_a_force_is_bounded_by_the_joints_that_exert_it(rows: int) -> None:
    """Three fingers at 5 N/rad, each along its normal or in three components."""
    normals = np.kron(np.eye(3), np.eye(3)[:, :1] if rows == 3 else np.eye(1))
    task = task_of(controller(FORCE.times(3), speed=0.3), 3 * rows)
    moved = rate(task, normals @ np.array([2.0, 0.1, -2.0]), 5 * normals)
    np.testing.assert_allclose(moved, normals @ np.array([1.5, 0.4, -1.5]))


def test_force_without_an_exerting_joint_requests_no_motion() -> None:
    task = task_of(controller(FORCE, speed=0.3))
    np.testing.assert_array_equal(rate(task, np.ones(3), np.zeros((3, 4))), np.zeros(3))


@pytest.mark.parametrize("gain", [1.0, 8.0, 40.0])
@pytest.mark.parametrize("speed", [None, 0.35])
@pytest.mark.parametrize("distance", [0.01, 0.3, 2.0])
def test_acceleration_is_bounded_and_the_goal_not_overshot(
    gain: float, speed: float | None, distance: float
) -> None:
    task = task_of(controller(POSITION, gain=gain, speed=speed, acceleration=1.5))
    error, before = np.array([distance, 0.0, 0.0]), np.zeros(3)
    for _ in range(2400):
        moved = rate(task, error)
        assert np.linalg.norm(moved - before) <= 1.5 * TICK * (1 + 1e-9)
        error, before = error - moved * TICK, moved
        assert error[0] > -5e-3 * distance
    assert abs(error[0]) < 1e-3 * distance


@pytest.mark.parametrize("gain", [2 / TICK, 10 / TICK])
def test_no_gain_leads_past_the_reference(gain: float) -> None:
    residual = np.array([0.3, -0.2, 0.1])
    moved = rate(task_of(controller(POSITION, gain=gain)), residual)
    assert moved * TICK == pytest.approx(residual)


def test_acceleration_is_bounded_relative_to_the_last_displacement() -> None:
    task, error = task_of(controller(HEADING, acceleration=1.5)), np.array([1.0, 0.0])
    first = rate(task, error)
    assert np.linalg.norm(rate(task, error)) > np.linalg.norm(first)
    task.displacement[:] = 0.0
    np.testing.assert_array_equal(rate(task, error), first)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_steps_that_are_not_finite_are_refused_and_change_nothing(bad: float) -> None:
    task = task_of(controller(POSITION, speed=0.35, acceleration=1.5))
    before = rate(task, np.ones(3)) * TICK
    residual = np.array([0.0, bad, 0.0])
    assert not task.move(0.5 * residual, residual, np.eye(3))
    np.testing.assert_array_equal(task.displacement, before)


@pytest.mark.parametrize("potential", ["manipulability", "localizability"])
def test_speed_of_a_scalar_potential_is_that_of_the_joints(potential: str) -> None:
    task = task_of(replace(controller(configuration(3), speed=0.1), potential=potential))
    row, step = np.array([[0.03, 0.0, 0.04]]), np.array([-50.0])
    assert task.move(step, step, row)
    # The shortest way of the joints to make the row's displacement.
    assert abs(task.displacement[0]) == pytest.approx(0.1 * TICK * np.linalg.norm(row))
