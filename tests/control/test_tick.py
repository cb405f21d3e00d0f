"""A controller's tick in one compiled call does what evaluating and bounding it do in turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from cbdsl.control.manipulability import Manipulability
from cbdsl.control.potential import Potential
from cbdsl.control.range import Range
from cbdsl.control.rotation import exp
from cbdsl.control.signal import Floats, Signal
from cbdsl.control.spring import Spring
from cbdsl.control.stack import Stack
from cbdsl.control.task import Task
from cbdsl.program.controller import Controller
from cbdsl.sensing.reading import Reading
from cbdsl.sensing.selection import columns_of, columns_of_both
from cbdsl.types.resource_type import FORCE, ORIENTATION, POSITION, ResourceType, configuration
from tests.control.test_task import TICK, controller

COLUMNS = np.array([5, -1, 0, 3, 7])
JOINTS = 9
ROWS = 3


def made(potential: str, kind: ResourceType, **settings: float) -> Controller:
    return replace(controller(kind, **settings), potential=potential)


#: Every potential that is compiled, with controllers that bound it in every way.
CASES: list[tuple[Potential, Controller]] = [
    (Spring(POSITION), made("spring", POSITION)),
    (Spring(POSITION), made("spring", POSITION, speed=0.1, acceleration=1.5)),
    (Spring(configuration(ROWS)), made("spring", configuration(ROWS), speed=0.1)),
    (Spring(FORCE.times(ROWS), along_normals=True), made("spring", FORCE.times(ROWS), speed=0.3)),
    (Spring(ORIENTATION, "z"), made("spring", ORIENTATION, speed=0.4)),
    (Range(np.full(ROWS, -3.0), np.full(ROWS, 4.0)), made("range", configuration(ROWS))),
    (Manipulability(), made("manipulability", configuration(ROWS), speed=0.2)),
]


def joined(task: Task, stack: Stack) -> Task:
    task.join(stack, 0, COLUMNS)
    return task


def drawn(controller: Controller, rng: np.random.Generator) -> Floats:
    """A value of a controller's feedback."""
    numbers = rng.normal(size=ROWS)
    return exp(numbers) if controller.feedback.type == ORIENTATION else numbers


def readings(controller: Controller, rng: np.random.Generator) -> Iterator[Reading]:
    for _ in range(8):
        rows, bent = rng.normal(size=(ROWS, JOINTS)), rng.normal(size=(ROWS, JOINTS, JOINTS))
        yield Reading(drawn(controller, rng), rows, 0, curvature=bent)


def evaluated(
    potential: Potential, reading: Reading, reference: Floats, stack: Stack, task: Task
) -> tuple[float, float]:
    """The same in turn."""
    assert reading.curvature is not None
    rows, bent = columns_of(reading.jacobian, COLUMNS), columns_of_both(reading.curvature, COLUMNS)
    found = potential.evaluate(Signal("feedback", reading.value, rows, bent), reference)
    stack.put(0, task.level(found))
    return found.phi, float(np.linalg.norm(found.residual))


@pytest.mark.parametrize(("potential", "controller"), CASES)
def test_it_does_what_evaluating_and_bounding_do(
    potential: Potential, controller: Controller, rng: np.random.Generator
) -> None:
    at_once, in_turn = (Task(controller, potential, TICK) for _ in range(2))
    ours, theirs = (Stack([("one", potential.size)], len(COLUMNS)) for _ in range(2))
    # A task remembers its rate, and a stack three ticks.
    for reading in readings(controller, rng):
        reference = drawn(controller, rng)
        for stack in (ours, theirs):
            stack.turn()
        found = joined(at_once, ours).act(reading, reference, 0.0)
        expected = evaluated(potential, reading, reference, theirs, in_turn)
        assert found == pytest.approx(expected, rel=1e-9)
        np.testing.assert_allclose(ours.rows, theirs.rows, atol=1e-9)
        np.testing.assert_allclose(ours.wanted, theirs.wanted, atol=1e-12)
        np.testing.assert_array_equal(ours.ages, theirs.ages)


def test_a_position_is_sent_above_its_reference_and_judged_by_it(rng: np.random.Generator) -> None:
    potential, task_of = Spring(POSITION), controller(POSITION)
    reading, reference = next(readings(task_of, rng)), rng.normal(size=ROWS)
    wanted, found = [], []
    for raised, goal in ((0.2, reference), (0.0, reference + np.array([0.0, 0.0, 0.2]))):
        stack = Stack([("one", 3)], len(COLUMNS))
        task = Task(task_of, potential, TICK)
        found.append(joined(task, stack).act(reading, goal, raised))
        wanted.append(stack.wanted)
    np.testing.assert_allclose(wanted[0], wanted[1], atol=1e-12)
    assert found[0][0] == pytest.approx(0.5 * np.sum((reference - reading.value) ** 2))
    assert found[0][0] != pytest.approx(found[1][0])


@pytest.mark.parametrize(("potential", "controller"), CASES)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_left_to_be_refused(
    potential: Potential, controller: Controller, bad: float, rng: np.random.Generator
) -> None:
    reading, reference = next(readings(controller, rng)), drawn(controller, rng)
    stack, task = Stack([("one", potential.size)], len(COLUMNS)), Task(controller, potential, TICK)
    reading.jacobian[1, COLUMNS[0]] = bad
    assert all(np.isnan(joined(task, stack).act(reading, reference, 0.0)))
    assert stack.ages[0] == 0
    assert not stack.wanted.any()


@pytest.mark.parametrize(("potential", "controller"), CASES[:-1])
def test_what_is_misshapen_is_left_to_be_refused(
    potential: Potential, controller: Controller, rng: np.random.Generator
) -> None:
    stack, task = Stack([("one", potential.size)], len(COLUMNS)), Task(controller, potential, TICK)
    for reading in readings(controller, rng):
        longer = reading._replace(value=np.zeros(ROWS + 1))
        assert np.isnan(joined(task, stack).act(longer, np.zeros(ROWS), 0.0)[0])
    if isinstance(potential, Spring):
        assert np.isnan(joined(task, stack).act(reading, np.zeros(ROWS + 1), 0.0)[0])
    assert stack.ages[0] == 0


def test_near_a_singularity_manipulability_is_left_to_be_evaluated(
    rng: np.random.Generator,
) -> None:
    potential, controller = CASES[-1]
    reading = next(readings(controller, rng))
    reading.jacobian[2] = reading.jacobian[0] + reading.jacobian[1]
    stack = Stack([("one", 1)], len(COLUMNS))
    found = joined(Task(controller, potential, TICK), stack).act(reading, np.zeros(0), 0.0)
    assert all(np.isnan(found))
    assert stack.ages[0] == 0
