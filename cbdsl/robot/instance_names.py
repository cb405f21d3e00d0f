"""Names of the instances of a channel: ``stereo.red.2`` is the second red object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.documents.robot import RobotDocument
from cbdsl.types.resource import SELECTIONS, Resource


class InstanceName(NamedTuple):
    """Name of a resource with an instance after its channel.

    Attributes:
        base: Resource of the attended object.
        instance: Text after its channel.
    """

    base: Resource
    instance: str

    def resource(self, name: str) -> Resource:
        """Return the resource of the instance, by its whole name."""
        source = self.base.source._replace(instance=self.instance)  # type: ignore[call-arg]
        return self.base._replace(name=name, source=source)


def parse_instance(name: str, named: Mapping[str, Resource]) -> InstanceName | None:
    """Return the parts of a name such as ``stereo.red.2``; ``None`` if it names no channel.

    Args:
        name: Name of a resource.
        named: Resources of the robot by name.
    """
    parts = name.split(".")
    if len(parts) < 3:
        return None
    # The instance is the third part: stereo.red.2.velocity belongs to stereo.red.velocity.
    base = named.get(".".join((*parts[:2], *parts[3:])))
    if base is None or not hasattr(base.source, "instance"):
        return None
    return InstanceName(base, parts[2])


def instance_names(robot: RobotDocument) -> tuple[str, ...]:
    """Return the instances that a robot's programs may name: numbers and selections."""
    if not robot.has_stereo:
        return ()
    numbers = range(1, robot.vision.regions.instances + 1)
    return (*map(str, numbers), *SELECTIONS)


def is_meant_as_instance(text: str) -> bool:
    """Return whether a text is a number, or similar to the name of a selection."""
    return text.isdigit() or nearest_name(text, SELECTIONS) is not None
