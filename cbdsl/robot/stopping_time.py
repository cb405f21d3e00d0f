"""Stopping time: the longest time until a driven robot stands, by its document."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from cbdsl.documents.driver import Driver
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel

#: Longest stopping time for which a document has no warning, s.
ACCEPTED = 0.15
# Control periods until a reference is reached, where the driver states no horizon, so that a late
# reference does not stop the controller in between. And the time to a joint's largest speed, where
# it states no acceleration, s.
_PERIODS, _RAMP = 3.0, 0.05
# Rounding errors of quotients and sums of times.
_ROUNDING = 1e-6


class StoppingTime(NamedTuple):
    """Longest times until the joints of a driver stand, s, if all clocks agree.

    Attributes:
        death: Time from the end or the suspension of the program.
        fault: Time from a fault that the program notices, without the return to the measured
            positions.
    """

    death: float
    fault: float


def horizon(driver: Driver, rate: float) -> float:
    """Return the time in which the controller of a driver reaches a reference, s."""
    return driver.horizon or _PERIODS / rate


def acceleration(driver: Driver | None, speed: float) -> float:
    """Return the largest acceleration of the reference of a joint with a largest speed."""
    stated = None if driver is None else driver.acceleration
    return stated or speed / _RAMP


def stopping_time(robot: RobotDocument, model: UrdfModel, name: str) -> StoppingTime:
    """Return the longest times until the joints of a driver stand.

    The controller ends a trajectory after its horizon. A watchdog, which a controller of bare
    positions needs, waits for the deadline and brakes. The program notices a fault within the
    deadline, if the trajectory has not ended before, and brakes. It sends references until it
    notices that load cells are silent. The joints move at the largest speed of the control law.

    Args:
        robot: Robot with drivers.
        model: URDF of the robot.
        name: Name of the driver.
    """
    driver, rate = robot.drivers[name], robot.control.rate
    period, reach = 1.0 / rate, horizon(driver, rate)
    braking = 0.0
    for _, largest, speed in speeds(robot, model, name):
        braking = max(braking, speed / acceleration(driver, largest))
    braking = period * math.ceil(braking * rate - _ROUNDING)
    if driver.form == "positions":
        # The watchdog notices both in its next period, and each reference is reached in another.
        death = driver.deadline + period + braking + period
        return StoppingTime(death, death)
    blind = max((each.deadline for each in robot.drivers.values() if each.wrenches), default=0.0)
    noticed = max(min(driver.deadline, reach), blind)
    return StoppingTime(reach + period, noticed + braking + reach)


def speeds(robot: RobotDocument, model: UrdfModel, name: str) -> Iterator[tuple[str, float, float]]:
    """Yield joint, largest speed and largest commanded speed of each joint of a driver."""
    control = robot.control.joint_speed
    for joint in (j for e in robot.drivers[name].moves for j in robot.joints(e)):
        limit = model.joints[joint].velocity
        largest = limit if math.isfinite(limit) else control
        yield joint, largest, min(largest, control)


def stopping_times(robot: RobotDocument, model: UrdfModel) -> dict[str, StoppingTime]:
    """Return the stopping times of all drivers that move joints, by name."""
    return {n: stopping_time(robot, model, n) for n, d in robot.drivers.items() if d.moves}


def stopping_lines(robot: RobotDocument, model: UrdfModel, *, slow: bool = False) -> list[str]:
    """Return a sentence for each driver that moves joints, or for the slow ones alone."""
    lines = []
    for name, time in stopping_times(robot, model).items():
        is_slow = max(time) > ACCEPTED + 5e-4  # as printed
        warning = f"; {1e3 * ACCEPTED:.0f} ms are accepted (CB325)" if is_slow else ""
        if is_slow or not slow:
            lines.append(
                f"driver '{name}' stands {1e3 * time.death:.0f} ms after its program ends and "
                f"{1e3 * time.fault:.0f} ms after a fault, at {robot.control.rate:g} Hz{warning}"
            )
    return lines
