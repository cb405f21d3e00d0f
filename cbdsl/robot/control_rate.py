"""Control rate that replaces the rate of a robot's document for one run."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument

# Bounds of a rate, Hz: a control tick takes about a millisecond.
_SLOWEST, _FASTEST = 1.0, 1000.0
# A Newton step of a spring is half of its residual (Eq 3.18).
# A gain above this many times the rate passes its reference within a tick.
_GAIN = 2.0
# Least ticks in a window of quiescence, and least periods in a driver's times.
_IN_WINDOW, _PERIODS = 2.0, 1.5


def with_control_rate(robot: RobotDocument, rate: float | None) -> RobotDocument:
    """Return a robot with another control rate, and a physics rate that is a multiple of it.

    Args:
        robot: Robot.
        rate: Control rate, Hz; the document's if ``None``.

    Raises:
        UsageError: The rate is out of range, or does not fit the document; the message names each
            reason.
    """
    if rate is None:
        return robot
    if not _SLOWEST <= rate <= _FASTEST:  # which NaN is not
        raise UsageError(f"--rate {rate:g}: a control rate is from {_SLOWEST:g} to {_FASTEST:g} Hz")
    if problems := list(_problems(robot, rate)):
        raise UsageError(
            f"--rate {rate:g} does not fit robot '{robot.name}': {'; '.join(problems)}"
        )
    # Physics never gets slower than the document's rate, so the number of steps in a tick is
    # rounded up. The margin keeps rounding errors of the quotient from adding a step to an exact
    # multiple.
    steps = max(1, math.ceil(robot.simulation.physics_rate / rate - 1e-9))
    control = robot.control.model_copy(update={"rate": rate})
    simulation = robot.simulation.model_copy(update={"physics_rate": steps * rate})
    return robot.model_copy(update={"control": control, "simulation": simulation})


def _problems(robot: RobotDocument, rate: float) -> Iterator[str]:
    """Yield the parts of a document that do not fit a rate, with the least rate that fits."""
    if robot.cameras and robot.vision.rate > rate:
        yield f"its cameras have {robot.vision.rate:g} images per second"
    for name, task in robot.control.tasks.items():
        if task.gain > _GAIN * rate:
            yield f"the gain of '{name}', {task.gain:g} /s, needs {task.gain / _GAIN:g} Hz"
        window = task.quiescence.window
        if window * rate < _IN_WINDOW - 1e-9:
            yield f"the window of '{name}', {window:g} s, needs {_IN_WINDOW / window:g} Hz"
    for name, driver in robot.drivers.items():
        for key, value in (("deadline", driver.deadline), ("horizon", driver.horizon)):
            if value is not None and value * rate < _PERIODS:
                yield (
                    f"the {key} of driver '{name}', {1e3 * value:g} ms, needs "
                    f"{_PERIODS / value:g} Hz"
                )
