"""Names of marks of one hue: ``mark.red.blue`` leads to what is blue on a red thing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cbdsl.documents.robot import RobotDocument
from cbdsl.types.resource import MarkHeading, Resource

#: In the place of a hue: whichever the mark has, as where no hue is named.
ANY = "any"


class MarkName(NamedTuple):
    """A mark's name with a hue behind the channel of the thing.

    Attributes:
        base: the heading to a mark of any hue.
        hue: what stands behind the channel.
    """

    base: Resource
    hue: str

    def resource(self, name: str, robot: RobotDocument) -> Resource | None:
        """The heading to a mark of that hue; ``None`` where the thing can have no such mark.

        Args:
            name: its whole name.
            robot: has the channels and their aliases.
        """
        if self.hue == ANY:
            return self.base
        if self.hue not in self.hues(robot):
            return None
        hue = robot.vision.channels.aliases.get(self.hue, self.hue)
        return self.base._replace(name=name, source=self._mark._replace(hues=(hue,)))

    def hues(self, robot: RobotDocument) -> tuple[str, ...]:
        """Hues that may stand there, ``any`` among them; a thing's own is none.

        Args:
            robot: has the aliases.
        """
        hues = [hue for hue in self._mark.hues if hue != self._mark.channel]
        aliases = robot.vision.channels.aliases.items()
        return ANY, *(alias for alias, channel in aliases if channel in hues), *hues

    @property
    def _mark(self) -> MarkHeading:
        assert isinstance(self.base.source, MarkHeading)
        return self.base.source


def parse_mark(name: str, named: Mapping[str, Resource]) -> MarkName | None:
    """The parts of a name such as ``mark.red.blue``; ``None`` where it names no mark.

    Args:
        name: of a resource.
        named: the robot's resources by name.
    """
    base = named.get(".".join(name.split(".")[:2]))
    if name.count(".") != 2 or base is None or not isinstance(base.source, MarkHeading):
        return None
    return MarkName(base, name.rpartition(".")[2])
