"""Drivers that speak ROS 2: rules for their topics."""

from __future__ import annotations

import re
from collections.abc import Iterator

from cbdsl.extend.driver import Driver, DriverKind, Problem, absolute, addresses

# Names of ROS 2: tokens of letters, digits and underscores, separated by slashes. A token does not
# begin with a digit and has no two underscores in a row (design.ros2.org, "Topic and Service name
# mapping").
_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_LONGEST = 247


def guarded(topic: str) -> str:
    """Return the topic at which a watchdog takes the references for a controller's topic."""
    return f"{absolute(topic)}/guarded"


def _problems(driver: Driver) -> Iterator[Problem]:
    for steps, address in addresses(driver):
        if address.startswith("~"):
            yield steps, f"'{address}' is private to a node; give the absolute topic"
        elif not _TOPIC.fullmatch(address) or "__" in address or len(address) > _LONGEST:
            yield steps, f"'{address}' is not a topic of ROS 2, such as /joint_states"
    yield from _taken(driver)
    for camera in driver.images:
        if camera not in driver.camera_info:
            yield ("images", camera), f"'camera_info' lacks camera '{camera}', to compare its lens"
    for camera in driver.camera_info:
        if camera not in driver.images and camera not in driver.regions:
            yield ("camera_info", camera), f"it has neither 'images' nor 'regions' of '{camera}'"
    for option in driver.options:
        yield ("options", option), f"kind ros2 has no option '{option}'"


def _taken(driver: Driver) -> Iterator[Problem]:
    """Yield the addresses at which a watchdog reads references."""
    topic = guarded(driver.commands or "")
    for steps, address in addresses(driver) if driver.form == "positions" else ():
        if absolute(address) == topic:
            yield steps, f"the watchdog of 'commands' reads references at '{topic}'"


ROS2 = DriverKind("ros2", "topics of ROS 2, by DDS", _problems, "cbdsl_ros2.ros2_link:Ros2Link")
