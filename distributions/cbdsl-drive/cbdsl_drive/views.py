"""Views: the streams of a robot's cameras that a run reads."""

from __future__ import annotations

from cbdsl.extend.backend import RobotDocument


def with_views(robot: RobotDocument, *, ideal: bool) -> RobotDocument:
    """Return a robot whose drivers have either regions or images.

    Args:
        robot: Robot with drivers.
        ideal: True for regions.
    """
    left_out = "images" if ideal else "regions"
    drivers = {
        name: driver.model_copy(update={left_out: {}}) for name, driver in robot.drivers.items()
    }
    return robot.model_copy(update={"drivers": drivers})
