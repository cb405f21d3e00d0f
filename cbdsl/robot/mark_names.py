"""Names of marks of one hue: ``mark.red.blue`` leads to a blue part of a red object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.documents.robot import RobotDocument
from cbdsl.types.resource import MarkHeading, Resource
from cbdsl.types.source_record import channel_of, hues_of

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
