"""From evaluations to levels: gain, speed, acceleration and braking."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.potential import Evaluation, gradient_descent, half_square, newton
from cbdsl.control.signal import Floats, Signal, SignalError
from cbdsl.control.task import Task
from cbdsl.program.controller import Controller, Quiescence
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import FORCE, HEADING, POSITION, ResourceType, configuration

TICK = 1 / 120


def controller(kind: ResourceType, **settings: float | None) -> Controller:
    feedback = Resource("feedback", kind, Origin.KINEMATICS, EffectorConfiguration("arm"), True)
    plain = Controller(
        "reach", "spring", feedback, None, feedback, (), (), False, 8.0, None, None,
        Quiescence(1e-3, 0.3, None),
    )  # fmt: skip
    return replace(plain, **settings)


class Sized(NamedTuple):
    """As much of a potential as a task wants to know."""

    size: int
    compiled: None = None

    def evaluate(self, signal: Signal, reference: Floats | None) -> Evaluation:
        raise NotImplementedError


def task_of(controller: Controller, size: int | None = None) -> Task:
    scalar = POTENTIALS[controller.potential].scalar
    own = 1 if scalar else controller.feedback.type.size
    return Task(controller, Sized(size or own), TICK)


def rate(task: Task, residual: Floats, jacobian: Floats | None = None) -> Floats:
    """Task displacement per second."""
    rows = np.eye(len(residual)) if jacobian is None else jacobian
    return task.level(half_square(residual, rows)).velocity / TICK


def test_gain_times_newton_step_times_period() -> None:
    level = task_of(controller(POSITION, gain=8.0)).level(
        half_square(np.array([0.1, 0.0, -0.2]), np.ones((3, 7)))
    )
    np.testing.assert_allclose(level.velocity, 4 * TICK * np.array([0.1, 0.0, -0.2]))
    assert level.name == "reach"
    assert level.jacobian.shape == (3, 7)


@given(st.lists(st.floats(-10, 10), min_size=3, max_size=3))
def test_speed_bounds_the_norm_and_keeps_the_direction(residual: list[float]) -> None:
    error = np.array(residual)
    moved = rate(task_of(controller(POSITION, speed=0.35)), error)
    assert np.linalg.norm(moved) <= 0.35 * (1 + 1e-12)
    np.testing.assert_allclose(np.cross(moved, error), 0, atol=1e-9)
    assert moved @ error >= 0


def test_speed_of_a_configuration_is_that_of_its_fastest_joint() -> None:
    task = task_of(controller(configuration(3), speed=0.8))
    np.testing.assert_allclose(rate(task, np.array([1.0, -2.0, 0.5])), [0.4, -0.8, 0.2])


@pytest.mark.parametrize("rows", [1, 3])
def test_speed_of_forces_is_that_of_the_joints_that_exert_them(rows: int) -> None:
    """Three fingers at 5 N/rad, each along its normal or in three components."""
    normals = np.kron(np.eye(3), np.eye(3)[:, :1] if rows == 3 else np.eye(1))
    task = task_of(controller(FORCE.times(3), speed=0.3), 3 * rows)
    moved = rate(task, normals @ np.array([2.0, 0.1, -2.0]), 5 * normals)
    np.testing.assert_allclose(moved, normals @ np.array([1.5, 0.4, -1.5]))


def test_a_force_that_no_joint_exerts_asks_for_nothing() -> None:
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
    level = task_of(controller(POSITION, gain=gain)).level(half_square(residual, np.eye(3)))
    assert level.velocity == pytest.approx(residual)


def test_reset_starts_from_rest() -> None:
    task, error = task_of(controller(HEADING, acceleration=1.5)), np.array([1.0, 0.0])
    first = rate(task, error)
    assert np.linalg.norm(rate(task, error)) > np.linalg.norm(first)
    task.reset()
    np.testing.assert_array_equal(rate(task, error), first)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_evaluations_are_refused_by_name(bad: float) -> None:
    task = task_of(controller(POSITION, speed=0.35, acceleration=1.5))
    with pytest.raises(SignalError, match="reach"):
        task.level(half_square(np.array([0.0, bad, 0.0]), np.eye(3)))


@pytest.mark.parametrize("size", [1e-6, 1e-2, 10.0])
def test_a_gradient_moves_the_joints_by_gain_times_itself_however_short_it_is(size: float) -> None:
    """The law must not mistake a short gradient for a singularity."""
    gradient = size * np.array([[0.6, 0.0, 0.8]])
    manipulability = controller(configuration(3), gain=2.0)
    task = task_of(replace(manipulability, potential="manipulability"))
    limits = np.full(3, 1e3)
    law = Law(-limits, limits, LawSettings(joint_step=1e3))
    level = task.level(gradient_descent(-1.0, gradient[0]))
    step = law.solve([level], np.zeros(3)).displacement
    np.testing.assert_allclose(step, -2.0 * gradient[0] * TICK, rtol=1e-9)


def test_a_potential_at_rest_asks_for_nothing() -> None:
    task = task_of(replace(controller(HEADING.times(2)), potential="localizability"))
    level = task.level(newton(0.5, np.zeros(4)))
    assert not level.velocity.any()


@pytest.mark.parametrize("potential", ["manipulability", "localizability"])
def test_the_speed_of_a_scalar_potential_is_that_of_the_joints(potential: str) -> None:
    task = task_of(replace(controller(configuration(3), speed=0.1), potential=potential))
    level = task.level(newton(50.0, np.array([0.03, 0.0, 0.04])))
    moved = level.jacobian[0] * level.velocity[0]
    assert np.linalg.norm(moved) == pytest.approx(0.1 * TICK)
