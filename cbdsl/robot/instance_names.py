"""Names of instances and marks: ``stereo.red.2``, ``mark.red.blue`` of a red object's blue part."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.documents.robot import RobotDocument
from cbdsl.types.resource import SELECTIONS, MarkHeading, Resource
from cbdsl.types.source_record import channel_of, hues_of


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


#: Placeholder for every hue, equivalent to a name without a hue.
ANY = "any"


class MarkName(NamedTuple):
    """Name of a mark with a hue after the channel of the object.

    Attributes:
        base: Heading to a mark of any hue.
        hue: Text after the channel.
    """

    base: Resource
    hue: str

    def resource(self, name: str, robot: RobotDocument) -> Resource | None:
        """Return the heading to a mark of that hue; ``None`` if the object cannot have it.

        Args:
            name: Whole name of the mark.
            robot: Robot document with the channels and their aliases.
        """
        if self.hue == ANY:
            return self.base
        if self.hue not in self.hues(robot):
            return None
        hue = robot.vision.channels.aliases.get(self.hue, self.hue)
        return self.base._replace(
            name=name, source=MarkHeading(channel_of(self.base.source), (hue,))
        )

    def hues(self, robot: RobotDocument) -> tuple[str, ...]:
        """Return the allowed hues, including ``any`` and excluding the object's own hue.

        Args:
            robot: Robot document with the aliases.
        """
        hues = hues_of(self.base.source)
        aliases = robot.vision.channels.aliases.items()
        return ANY, *(alias for alias, channel in aliases if channel in hues), *hues


def parse_mark(name: str, named: Mapping[str, Resource]) -> MarkName | None:
    """Return the parts of a name such as ``mark.red.blue``; ``None`` if it names no mark.

    Args:
        name: Name of a resource.
        named: Resources of the robot by name.
    """
    base = named.get(".".join(name.split(".")[:2]))
    if name.count(".") != 2 or base is None or not hues_of(base.source):
        return None
    return MarkName(base, name.rpartition(".")[2])
