"""Distances between links as signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cbdsl.documents.robot import HullSection, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.nearest_links import NearestLinks
from cbdsl.numeric.arrays import Integers
from cbdsl.sensing.table.reading import Reading
from cbdsl.types.resource import LinkDistance, Resource
from cbdsl.types.source_record import sources_of


class LinkDistances:
    """Reader of the least distances between links and other bodies.

    Args:
        robot: Robot document.
        kinematics: Kinematics of the same robot.
        read: Function that reads a resource.
        clock: Count of the postures, shape (1,).
        hulls: Hulls around fixtures in the world frame, by name.
    """

    def __init__(
        self,
        robot: RobotDocument,
        kinematics: Kinematics,
        read: Callable[[Resource], Reading | None],
        clock: Integers,
        hulls: Mapping[str, HullSection],
    ) -> None:
        self._robot, self._kinematics, self._hulls = robot, kinematics, hulls
        self._read, self._clock = read, clock
        self._links: dict[LinkDistance, NearestLinks] = {}

    def read(self, source: LinkDistance) -> Reading | None:
        """Return the distance, m, and its slope; ``None`` without a pair, or an unseen object."""
        links = self._links.get(source)
        if links is None:
            model = self._kinematics.model
            links = self._links[source] = NearestLinks(self._robot, model, source, self._hulls)
        for feature in source.features:
            seen = self._read(feature)
            if seen is None:
                return None
            links.place(seen.value, seen.radius)
        if not links.are_known:
            return None
        slope = links.measure(self._kinematics.positions)
        return Reading(np.array([links.distance]), slope[None], int(self._clock[0]))

    def pair(self, resource: Resource) -> str:
        """Return the names of the links that were nearest at the last reading, or no text."""
        return next((self._links[each].pair for each in sources_of([resource], LinkDistance)), "")

    @property
    def clauses(self) -> tuple[str, ...]:
        """Clauses about the distances at their last readings."""
        return tuple(
            f"{source.name} is {100 * links.distance:.1f} cm, of {links.pair}"
            for source, links in self._links.items()
            if links.pair
        )
