"""Touch: forces on the hands' load cells, and their Jacobians (Eq 3.9)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from cbdsl.documents.robot import JointTorques, LoadCell, RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Booleans, Floats
from cbdsl.sensing.observation import Cell, Loads, Observation
from cbdsl.sensing.table.reading import Reading, stacked
from cbdsl.sensing.table.table import RowPart
from cbdsl.sensing.table.tips import Tips
from cbdsl.sensing.touch.cell_zeros import CellZeros
from cbdsl.sensing.touch.net_wrench import Fingertips, net_wrench
from cbdsl.types.resource import FingerForces, FingerLoad, NetForces, NetLoad

_ORIGIN = np.zeros(3)
_PARTS = {"force": slice(0, 3), "torque": slice(3, 6), "wrench": slice(0, 6)}


class Touch:
    """Reader of the load cells, whose first values are the zeros; see ``CellZeros``.

    The Jacobian of a signal is the cast force -> displacement (Eq 3.37 to 3.39). Objects are
    modelled as springs with the stiffness in the robot document.

    Attributes:
        cells: Load cells, as (hand, finger), in the order of the robot document.
        loads: Wrenches of the load cells without weight and bias, N and N m, world frame, shape
            (cells, 6).
        feeling: True for each load cell in contact, shape (cells,).
    """

    def __init__(self, robot: RobotDocument, kinematics: Kinematics, tips: Tips) -> None:
        self._robot = robot
        self._kinematics = kinematics
        self._tips = tips
        self.cells = tuple(
            (hand, finger) for hand, fingers in robot.load_cells.items() for finger in fingers
        )
        #: Slices of the cells, by hand.
        self._own = {hand: self._span(hand) for hand in robot.load_cells}
        #: Indices of the joints that flex the fingers, by hand.
        self.flexing = {
            hand: kinematics.joints.pick([cell.joint for cell in fingers.values()])
            for hand, fingers in robot.load_cells.items()
        }
        #: Unit normal of a link's load cell in the link's frame, by link.
        self._normals = {
            cell.link: np.array(cell.normal) / math.hypot(*cell.normal)
            for fingers in robot.load_cells.values()
            for cell in fingers.values()
        }
        #: Sign of the joint velocity with which the fingers close, 1 or -1, by hand.
        self.closing = {hand: self._closing(hand) for hand in robot.load_cells}
        self._flexions = {hand: self._flexion(hand) for hand in robot.load_cells}
        #: Effector whose tip carries the hand, by hand.
        self.carriers = {
            hand: carrier
            for hand in robot.load_cells
            if (carrier := _carrier(robot, kinematics, hand)) is not None
        }
        control = robot.control
        self._yielding = np.array((control.contact_stiffness, control.contact_torsion))
        self._fingertips: dict[str, Fingertips] = {}
        links = [robot.load_cells[hand][finger].link for hand, finger in self.cells]
        self._zeros = CellZeros(robot.contact, kinematics, links)
        self.loads: Floats = np.zeros((len(self.cells), 6))
        self.feeling: Booleans = np.zeros(len(self.cells), dtype=np.bool_)
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self._zeros.reset()
        self._forget()

    def resume(self, before: Touch) -> None:
        """Begin an episode at the end of another one.

        The load cells are tared again only if none was in contact, so that a held object is still
        measured.

        Args:
            before: Touch at the last tick of the previous episode; may be this object.
        """
        if before.touching_anything():
            self._zeros.resume(before._zeros)
        else:
            self._zeros.reset()
        self._forget()

    def _forget(self) -> None:
        self.loads[:], self.feeling[:] = 0.0, False
        self._in_contact = self.feeling.tolist()
        self._touching = False

    def gathered(self, loads: Mapping[Cell, Floats]) -> Floats:
        """Return wrenches in the order of the robot document, shape (cells, 6)."""
        if isinstance(loads, Loads) and loads.cells == self.cells:
            return loads.wrenches
        wrenches = [loads[cell] for cell in self.cells]
        return np.array(wrenches).reshape(len(wrenches), 6)

    def update(self, wrenches: Floats, time: float) -> None:
        """Update from one tick's wrenches; the kinematics must have its posture.

        Args:
            wrenches: Wrenches from ``gathered``, N and N m, world frame, shape (cells, 6).
            time: Time of the tick, s.
        """
        before = self._touching
        self._touching = self._zeros.remove(wrenches, time, self.loads, self.feeling)
        if before or self._touching:
            self._in_contact = self.feeling.tolist()

    def touching_anything(self) -> bool:
        """Return whether any fingertip of any hand measures more than the contact threshold."""
        return self._touching

    def touching(self, hand: str) -> bool:
        """Return whether any fingertip of a hand measures more than the contact threshold."""
        return True in self._in_contact[self._own[hand]]

    def all_touching(self, hand: str) -> bool:
        """Return whether every fingertip of a hand measures more than the contact threshold."""
        return False not in self._in_contact[self._own[hand]]

    def all_holding(self, group: str) -> bool:
        """Return whether every hand of a group touches more than another hand's fingertips."""
        hands = self.hands(group)
        if not all(self.touching(hand) for hand in hands):
            return False
        if len(hands) == 1:
            return True  # a single hand cannot touch another one
        # Two hands that press on each other are in contact, too, without any object between them.
        nearest, tips = self._robot.contact.self_contact, [self._touching_tips(h) for h in hands]
        for place, own in enumerate(tips):
            others = np.vstack([each for i, each in enumerate(tips) if i != place])
            apart = np.linalg.norm(own[:, None] - others[None], axis=2).min(axis=1)
            if not (apart > nearest).any():
                return False
        return True

    def _touching_tips(self, hand: str) -> Floats:
        """Return origins of the fingertips of a hand that are in contact, m, shape (k, 3)."""
        links = [cell.link for cell in self._fingers(hand).values()]
        in_contact = self._in_contact[self._own[hand]]
        return np.array(
            [
                self._kinematics.frame(link).position
                for link, touches in zip(links, in_contact, strict=True)
                if touches
            ]
        )

    def hands(self, name: str) -> tuple[str, ...]:
        """Return the hands of a group, or the named hand itself."""
        return self._robot.members(name)

    def shares(self, hand: str) -> Floats:
        """Return each finger's share of a force reference, shape (fingers,)."""
        return np.array([cell.share for cell in self._fingers(hand).values()])

    def finger_load(self, source: FingerLoad) -> Reading | None:
        """Return the load of one finger, or ``None`` without contact."""
        if not self._in_contact[self.cells.index((source.hand, source.finger))]:
            return None
        return self._load(source.hand, source.finger, source.part)

    def net_load(self, source: NetLoad) -> Reading | None:
        """Return the net load of a hand's fingers, or ``None`` without any contact."""
        if not self.touching(source.hand):
            return None
        return self._net(source.hand, source.part)

    def net_forces(self, source: NetForces) -> Reading | None:
        """Return the net force of each hand, or ``None`` unless all of them hold an object."""
        if not self.all_holding(source.group):
            return None
        return stacked([self._net(hand, "force") for hand in self.hands(source.group)])

    def finger_forces(self, source: FingerForces) -> Reading | None:
        """Return the force of every finger, or ``None`` unless all of them are in contact."""
        if not self.all_touching(source.hand):
            return None
        forces = self.loads[self._own[source.hand], :3]
        normals = [
            self._kinematics.direction(cell.link, self._normals[cell.link])
            for cell in self._fingers(source.hand).values()
        ]
        flexions = self._flexions[source.hand]
        rows = [np.outer(n, row) for n, row in zip(normals, flexions, strict=True)]
        return Reading(forces.ravel(), np.vstack(rows), self._tips.stamp)

    def pads(self, hand: str) -> tuple[Sequence[RowPart], Floats]:
        """Return parts and Jacobian of the row of forces along a hand's load cell normals.

        These forces are defined without contact too, as a measured zero, so that a hand can close
        on an object. A finger's force depends on the joint that flexes it. Fingers that one joint
        flexes for equal forces have their mean, since this joint cannot change the difference.
        """
        parts, fingers = [], self._fingers(hand)
        drives = [(cell.joint, cell.share) for cell in fingers.values()]
        for place, cell in enumerate(fingers.values()):
            link, number = self._kinematics.link(cell.link), self._own[hand].start + place
            normal = link.rotation.dot(self._normals[cell.link])
            part = RowPart(link.frame, link.point(cell.pad), cell=number, normal=normal)
            parts.append(part._replace(shift=drives.index(drives[place]), radius=cell.radius))
        return parts, self._flexions[hand]

    def finger_parts(self, source: FingerLoad) -> list[RowPart]:
        """Return the fingertip as the part of a row of its force; a torque has none."""
        own = () if source.part == "torque" else (source.finger,)
        return self._force_parts(source.hand, own)

    def hand_parts(self, source: NetLoad) -> list[RowPart]:
        """Return the fingertips of a hand as parts of a row of their force; a torque has none."""
        own = () if source.part == "torque" else self._fingers(source.hand)
        return self._force_parts(source.hand, own)

    def group_parts(self, source: NetForces) -> list[RowPart]:
        """Return the fingertips of each hand of a group as parts of a row of forces."""
        return [
            part._replace(shift=3 * place)
            for place, hand in enumerate(self.hands(source.group))
            for part in self._force_parts(hand, self._fingers(hand))
        ]

    def palm_parts(self, source: NetForces) -> list[RowPart]:
        """Return the fingertips as parts of a row of forces along palms' normals."""
        parts = []
        for place, hand in enumerate(self.hands(source.group)):
            palm = self._tips.part(self.carriers[hand])
            normal = np.reshape(palm.rotation, (3, 3))[:, 2]
            parts += [
                part._replace(shift=place, guide=palm.frame, normal=normal)
                for part in self._force_parts(hand, self._fingers(hand))
            ]
        return parts

    def _force_parts(self, hand: str, fingers: Iterable[str]) -> list[RowPart]:
        links = [self._kinematics.link(self._fingers(hand)[finger].link) for finger in fingers]
        stiffness = float(self._yielding[0])
        return [
            RowPart(link.frame, link.position, support=link.support, weight=stiffness)
            for link in links
        ]

    def palm_forces(self, source: NetForces) -> Reading:
        """Return forces of hands along their palms' normals, N, with Jacobians by arm joints."""
        hands = self.hands(source.group)
        return stacked([self._palm_force(hand) for hand in hands])._replace(
            measured=self.all_holding(source.group)
        )

    def _palm_force(self, hand: str) -> Reading:
        """Return the component of a hand's net force along its palm's normal, shape (1,)."""
        normal, net = self._tips.normal(self.carriers[hand]), self._net(hand, "force")
        assert net.jacobian is not None
        jacobian = normal[None].dot(net.jacobian)
        return Reading(normal[None].dot(net.value), jacobian, self._tips.stamp)

    def _net(self, hand: str, part: str) -> Reading:
        """Return the net load of a hand's fingers; torques are about ``_centre``."""
        value, jacobian = np.empty(6), np.empty((6, len(self._kinematics.joints)))
        kinematics, where = self._kinematics, _PARTS[part]
        kinematics.place()
        centre = _ORIGIN if part == "force" else self._centre(hand)  # forces have none
        net_wrench(
            self.loads[self._own[hand]], centre, self._yielding, *self._tips_of(hand),
            kinematics.tree, kinematics.frames, kinematics.axes, value, jacobian,
        )  # fmt: skip
        return Reading(value[where], jacobian[where], self._tips.stamp)

    def _tips_of(self, hand: str) -> Fingertips:
        tips = self._fingertips.get(hand)
        if tips is None:
            links = [cell.link for cell in self._fingers(hand).values()]
            tips = self._fingertips[hand] = Fingertips.of(self._kinematics, links)
        return tips

    def _centre(self, hand: str) -> Floats:
        """Return the reference point of a hand's torques, m, world frame.

        It is the tip that carries the hand or, without one, the middle of its load cells.
        """
        carrier = self.carriers.get(hand)
        if carrier is not None:
            return self._tips.point(carrier).position
        links = [cell.link for cell in self._fingers(hand).values()]
        middle: Floats = np.mean([self._kinematics.frame(link).position for link in links], axis=0)
        return middle

    def _load(self, hand: str, finger: str, part: str) -> Reading:
        jacobian = self._kinematics.jacobian(self._fingers(hand)[finger].link)
        yielding = np.repeat(self._yielding, 3)[:, None]
        where = _PARTS[part]
        value = self.loads[self.cells.index((hand, finger)), where]
        return Reading(value, (yielding * jacobian)[where], self._tips.stamp)

    def _flexion(self, hand: str) -> Floats:
        """Return forces along the fingers' normals per joint, N/rad or N/m, shape (fingers, n)."""
        rows = np.zeros((len(self._fingers(hand)), len(self._kinematics.joints)))
        rows[np.arange(len(rows)), self.flexing[hand]] = self.closing[hand]
        control = self._robot.control
        return rows * np.where(self._kinematics.slides, control.slide_stiffness, control.stiffness)

    def _closing(self, hand: str) -> float:
        """Return the sign of the joint motion with which the fingers close."""
        along = 0.0
        for cell, joint in zip(self._fingers(hand).values(), self.flexing[hand], strict=True):
            normal = self._kinematics.direction(cell.link, self._normals[cell.link])
            along += float(normal @ self._kinematics.jacobian(cell.link)[:3, joint])
        return -1.0 if along < 0.0 else 1.0

    def _fingers(self, hand: str) -> Mapping[str, LoadCell]:
        return self._robot.load_cells[hand]

    def span(self, hand: str) -> tuple[int, int]:
        """Return the number of a hand's first load cell and the number after its last."""
        return self._own[hand].start, self._own[hand].stop

    def _span(self, hand: str) -> slice:
        first = next(row for row, (owner, _) in enumerate(self.cells) if owner == hand)
        return slice(first, first + len(self._fingers(hand)))


def _carrier(robot: RobotDocument, kinematics: Kinematics, hand: str) -> str | None:
    """Return the effector whose tip carries a hand: all of its joints move the fingertips."""
    cell = next(iter(robot.load_cells[hand].values()))
    moving = kinematics.moving(cell.link)
    return next(
        (
            name
            for name, effector in robot.effectors.items()
            if effector.tip is not None and moving.issuperset(effector.joints)
        ),
        None,
    )


class Strain:
    """Torques that the joints' drives exert beyond the weight of the links, low-pass filtered.

    A held object counts as a contact, and so do accelerations. The filter and the threshold in the
    robot document keep accelerations below a guard. Strain is computed only if it is needed.

    Attributes:
        torques: Joint torques that the robot exerts on the world, N m, shape (n,).
        needed: True if the torques are used.
    """

    def __init__(self, settings: JointTorques | None, kinematics: Kinematics) -> None:
        self._settings, self._kinematics = settings, kinematics
        self.torques: Floats = np.zeros(len(kinematics.joints))
        self.needed = False
        self.reset()

    def reset(self) -> None:
        """Forget the previous episode."""
        self.torques[:] = 0.0
        self._time = math.nan

    def update(self, observation: Observation) -> None:
        """Update from one tick's torques; the kinematics must have its posture."""
        if not self.needed or self._settings is None or observation.efforts is None:
            return
        passed, self._time = observation.time - self._time, observation.time
        if not passed > 0.0:
            return  # no drive has exerted a torque before the first step
        share = 1.0 - math.exp(-passed / self._settings.filter) if self._settings.filter else 1.0
        self.torques += share * (observation.efforts - self._kinematics.weight() - self.torques)
