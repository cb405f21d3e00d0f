"""Rows that follow from joint positions alone: configurations, tips and their combinations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbdsl.documents.robot import LoadCell, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.turned_posture import TurnedPosture
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Standoff
from cbdsl.robot.urdf import Numbers
from cbdsl.sensing.table.reading import Reading
from cbdsl.sensing.table.refresh import CONFIGURATION, LENGTH, MANIPULATOR, MIXTURE, TIP
from cbdsl.sensing.table.signal_rows import SignalRows
from cbdsl.sensing.table.table import Form, RowPart
from cbdsl.sensing.table.tips import Tips
from cbdsl.types import resource as sources


class KinematicRows:
    """Factory of rows that are compiled from the robot's kinematics.

    Args:
        robot, kinematics, tips: Document, kinematics and tips of the same robot.
        rows: Signal rows in which rows are bound.
    """

    def __init__(
        self, robot: RobotDocument, kinematics: Kinematics, tips: Tips, rows: SignalRows
    ) -> None:
        self._robot, self._kinematics, self._tips, self._rows = robot, kinematics, tips, rows
        self._turned: dict[str, Floats] = {}

    def joints(self, effector: str) -> int:
        """Return the row of an effector's joint positions, rad."""
        return self.configuration(sources.EffectorConfiguration(effector))

    def links(self, links: Sequence[str]) -> int:
        """Return the row of the mean position of some links' frames, m, world frame."""
        return self._rows.bound(("links", *links), lambda: self._bind_links(links))

    def tip_off(
        self, source: sources.Tip, facing: int, standoff: tuple[float, float, float] | Standoff
    ) -> int:
        """Return the row of a tip whose control point stands off along its z axis.

        Args:
            source: Tip of an effector.
            facing: Number of the row with the radius that the tip stands off from.
            standoff: Clearance beyond that radius, and the least and most distance, m.
        """
        key = "tip", source, facing, standoff
        return self._rows.bound(key, lambda: self._bind_point(source, facing, standoff))

    def manipulator(self, effector: str, part: str, joints: Sequence[str]) -> int:
        """Return the row of the Jacobian of an effector's or group's tips by some joints.

        Its own Jacobian is the curvature (Eq 3.5).

        Args:
            effector: Name of an effector or group.
            part: Part of the tip: ``position`` for three rows a tip, ``pose`` for six.
            joints: Names of the n joints, one for each column.
        """
        columns = self._kinematics.joints.pick(joints).tolist()
        tips = [self._tips.part(member) for member in self._robot.members(effector)]
        size = len(tips) * (3 if part == "position" else 6) * len(columns)
        form = Form(MANIPULATOR, size, size, tips, columns, angular=part != "position")
        key = "manipulator", effector, part, *joints
        return self._rows.bound(key, lambda: self._rows.bind(form))

    def configuration(self, source: sources.EffectorConfiguration) -> int:
        """Return the row of an effector's joint positions, rad."""
        key = sources.EffectorConfiguration, source
        return self._rows.bound(key, lambda: self._bind_configuration(source))

    def posture(self, source: sources.Posture) -> int:
        """Return a new row of the joint positions of a declared posture, rad."""
        angles = [
            angle
            for member in self._robot.members(source.effector)
            for angle in self._robot.effectors[member].postures[source.posture]
        ]
        return self._bind_constant(angles)

    def turned(self, source: sources.Turned) -> int:
        """Return a new row of the joint positions of a derived posture, rad."""
        effector = source.effector
        if effector not in self._turned:
            self._turned[effector] = TurnedPosture(self._robot, self._kinematics, effector).find()
        return self._bind_constant(self._turned[effector])

    def tip(self, source: sources.Tip) -> int:
        """Return the row of an effector's tip, or of a group's tips in sequence."""
        return self._rows.bound((sources.Tip, source), lambda: self._bind_tip(source))

    def centroid(self, source: sources.Centroid) -> int:
        """Return a new row of the mean position of a group's tips, m, world frame."""
        members = self._robot.members(source.group)
        return self._bind_mixture(members, [1.0 / len(members)] * len(members), 0)

    def separation(self, source: sources.Separation) -> int:
        """Return a new row of the vector from a group's first tip to its second, m, world frame."""
        return self._bind_mixture(self._robot.members(source.group), [-1.0, 1.0], 0)

    def grasp_centre(self, source: sources.GraspCentre) -> int:
        """Return a new row of the point between opposing fingertips, m, world frame."""
        return self._bind_opposed(source.hand, (0.5, 0.5))

    def opening(self, source: sources.Opening) -> int:
        """Return a new row of the distance between opposing fingertips, m."""
        apart = self._bind_opposed(source.hand, (-1.0, 1.0))
        # Other joints of the hand, such as a spread of the fingers, do not close it.
        flexing = [cell.joint for cell in self._robot.load_cells[source.hand].values()]
        columns = self._kinematics.joints.pick(flexing).tolist()
        return self._rows.bind(Form(LENGTH, 1, 1, (RowPart(source=apart),), columns), (apart,))

    def _bind_opposed(self, hand: str, weights: tuple[float, float]) -> int:
        """Return a row of the weighted sum of a thumb's position and that of the other fingers.

        The thumb is the finger with the largest share of the hand's force.
        """
        cells = self._robot.load_cells[hand].values()
        thumb = max(cells, key=lambda cell: cell.share)
        others = [cell for cell in cells if cell is not thumb]
        rows = [self._pad(cell) for cell in (thumb, *others)]
        shares = [weights[0], *(weights[1] / len(others) for _ in others)]
        parts = [RowPart(source=r, weight=w) for r, w in zip(rows, shares, strict=True)]
        return self._rows.bind(Form(MIXTURE, 3, 3, parts), rows)

    def _pad(self, cell: LoadCell) -> int:
        """Return the row of the middle of a pad, m, world frame."""
        key = "links", cell.link, *(cell.pad if any(cell.pad) else ())
        return self._rows.bound(key, lambda: self._bind_links([cell.link], cell.pad))

    def _bind_constant(self, values: Sequence[float] | Floats) -> int:
        number = self._rows.bind_written(len(values))
        self._rows.table.write(number, Reading(np.array(values), None, 0))
        return number

    def _bind_links(self, links: Sequence[str], offset: Numbers = (0.0, 0.0, 0.0)) -> int:
        if len(links) > 1:
            rows = [self.links([link]) for link in links]
            parts = [RowPart(source=row, weight=1.0 / len(rows)) for row in rows]
            return self._rows.bind(Form(MIXTURE, 3, 3, parts), rows)
        link = self._kinematics.link(links[0])
        part = RowPart(link.frame, link.point(offset), link.rotation.ravel(), link.support)
        return self._rows.bind(Form(TIP, 3, 3, (part,)))

    def _bind_configuration(self, source: sources.EffectorConfiguration) -> int:
        columns = self._kinematics.joints.of(source.effector).tolist()
        number = self._rows.bind(Form(CONFIGURATION, len(columns), len(columns), (), columns))
        self._rows.table.rows(number)[np.arange(len(columns)), columns] = 1.0
        return number

    def _bind_tip(self, source: sources.Tip) -> int:
        members = self._robot.members(source.effector)
        if members == (source.effector,):
            return self._bind_point(source, -1, (0.0, 0.0, 0.0))
        return self._bind_mixture(members, [1.0] * len(members), 3)

    def _bind_point(
        self, source: sources.Tip, facing: int, standoff: tuple[float, float, float] | Standoff
    ) -> int:
        linear, angular = source.part != "orientation", source.part != "position"
        form = Form(
            TIP, 3 * linear + 9 * angular, 3 * linear + 3 * angular,
            (self._tips.part(source.effector),), (), linear, angular, facing, standoff,
        )  # fmt: skip
        return self._rows.bind(form, () if facing < 0 else (facing,))

    def _bind_mixture(self, members: Sequence[str], weights: Sequence[float], shift: int) -> int:
        """Return a row of weighted tip positions, each ``shift`` components after the previous."""
        tips = [self.tip(sources.Tip(member, "position")) for member in members]
        parts = [
            RowPart(source=tip, weight=weight, shift=shift * place)
            for place, (tip, weight) in enumerate(zip(tips, weights, strict=True))
        ]
        size = 3 + shift * (len(members) - 1)
        return self._rows.bind(Form(MIXTURE, size, size, parts), tips)
