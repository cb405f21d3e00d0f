"""Hands of a proposed robot: postures, pads with load cells, surfaces and efforts."""

# Model: a pad is the last link that a joint of the hand moves, directly or by couplings, if it
# touches objects. The hand is open where its pads are far from each other, and each joint opens by
# itself. A pad presses towards the mean of the other pads, half-way between open and closed; a
# direction near an axis of its link is that axis. Its middle is as far along the finger as the tip
# of the arm, on the side to which the pad presses. The surfaces are those of soft rubber.

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cbdsl.kinematics.joint_tree import JointTree, PlacedJoint
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.tip_frame import shape_centre, shape_corners
from cbdsl.robot.urdf import Numbers, UrdfJoint, UrdfModel

# Part of a joint's range that postures keep off its ends.
_OFF = 0.03
# Stiffness, N/m, and damping, N s/m, of pads, and the largest force of one, N.
STIFFNESS, DAMPING, FORCE = 3000, 60, 60
# Cosine of an angle from an axis below which a direction is not that axis.
_NEAR = 0.85


class Pad(NamedTuple):
    """Link of a hand that presses on objects.

    Attributes:
        link: Name of the link.
        joint: Actuated joint that moves it.
        normal: Direction in which it presses, in its frame.
        lever: Way of the pad per motion of the joint, m/rad; 1 if the joint slides.
        middle: Middle of its surface, in its frame, m.
    """

    link: str
    joint: str
    normal: tuple[float, ...]
    lever: float
    middle: Numbers


class ProposedHand:
    """Hand with two pads or more; without them, it has one posture and no pads.

    Args:
        model: Model of the robot.
        joints: Actuated joints of the hand.

    Attributes:
        postures: Positions of the joints by name of the posture, rad or m, the first at the start.
        pads: Pads, in the order of the model.
    """

    def __init__(self, model: UrdfModel, joints: Sequence[UrdfJoint]) -> None:
        self._model, self._joints = model, tuple(joints)
        self._tree = JointTree(joint for root in model.roots for joint in model.beyond(root))
        self._movers = self._moving_joints()
        self._ends = self._end_links()
        self.pads: tuple[Pad, ...] = ()
        middle = [(joint.lower + joint.upper) / 2 for joint in joints]
        bounded = all(map(math.isfinite, middle))
        self.postures: dict[str, tuple[float, ...]] = {}
        if len(self._ends) < 2 or not bounded:
            return
        opened, closed = self._extremes(middle)
        self.postures = {"open": opened, "closed": closed}
        self.pads = tuple(self._pad(link, opened, closed) for link in self._ends)

    @property
    def span(self) -> float:
        """Mean distance between the surfaces of two pads of the open hand, m."""
        placed = self._centres(self.postures["open"])
        middles = [_point(placed[pad.link][1].child, pad.middle) for pad in self.pads]
        gaps = [np.linalg.norm(one - other) for one, other in itertools.combinations(middles, 2)]
        return float(np.mean(gaps))

    def aim(self, link: str, offset: Numbers) -> None:
        """Put the middles of the pads beside the arm's tip, at an offset in a link's frame, m."""
        placed = self._centres(self.postures["closed"])
        tip = _point(self._tree.place(self._model.rests)[link].child, offset)
        self.pads = tuple(self._aimed(pad, placed[pad.link][1].child, tip) for pad in self.pads)

    def _aimed(self, pad: Pad, at: Pose, tip: Floats) -> Pad:
        corners, normal = np.array(shape_corners(self._model, pad.link)), np.array(pad.normal)
        if not corners.size:
            return pad
        place, low, high = (
            (tip - at.position) @ at.rotation,
            corners.min(axis=0),
            corners.max(axis=0),
        )
        middle = np.where((low <= place) & (place <= high), place, (low + high) / 2)
        middle += ((corners @ normal).max() - middle @ normal) * normal
        return pad._replace(middle=tuple(round(float(each), 4) + 0.0 for each in middle))

    def grip(self, link: str) -> tuple[float, float, float]:
        """Return the point between the closing pads in the frame of a link that carries them, m."""
        placed = self._centres(self.postures["closed"])
        middle = np.mean([centre for centre, _ in placed.values()], axis=0)
        frame = self._tree.place({**self._model.rests})[link].child
        x, y, z = np.round(frame.rotation.T @ (middle - frame.position), 4) + 0.0
        return float(x), float(y), float(z)

    def _moving_joints(self) -> Mapping[str, str]:
        """Return the actuated joint of each joint that moves with one of the hand's."""
        own = {joint.name: joint.name for joint in self._joints}
        return own | {
            joint.name: joint.mimic.joint
            for joint in self._model.joints.values()
            if joint.movable and joint.mimic is not None and joint.mimic.joint in own
        }

    def _end_links(self) -> Mapping[str, str]:
        """Return the last touching link of each finger, with its actuated joint."""
        ends: dict[str, str] = {}
        for name, mover in self._movers.items():
            beyond = [*self._model.beyond(self._model.joints[name].child)]
            if any(not joint.fixed for joint in beyond):
                continue
            links = [self._model.joints[name].child, *(joint.child for joint in beyond)]
            touching = [link for link in links if self._model.bodies[link].collisions]
            if touching:
                ends[touching[-1]] = mover
        # A linkage ends in links that only brace the finger; the pads are the outermost ones.
        depths = {link: len(self._model.above(link)) for link in ends}
        deepest = max(depths.values(), default=0)
        return {link: mover for link, mover in ends.items() if depths[link] == deepest}

    def _extremes(self, middle: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the open and the closed posture."""
        opened, closed = [], []
        for index, joint in enumerate(self._joints):
            off = _OFF * (joint.upper - joint.lower)
            ends = [round(joint.lower + off, 4), round(joint.upper - off, 4)]
            spreads = [self._spread([*middle[:index], end, *middle[index + 1 :]]) for end in ends]
            wide = int(spreads[1] > spreads[0])
            opened.append(ends[wide])
            closed.append(ends[1 - wide])
        return tuple(opened), tuple(closed)

    def _spread(self, positions: Sequence[float]) -> float:
        centres = np.array([centre for centre, _ in self._centres(positions).values()])
        return float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).sum())

    def _centres(self, positions: Sequence[float]) -> dict[str, tuple[Floats, PlacedJoint]]:
        """Return the centre of each pad in the root's frame, m, and its placed joint."""
        given = {joint.name: at for joint, at in zip(self._joints, positions, strict=True)}
        for joint in self._model.joints.values():
            if joint.name in self._movers and joint.mimic is not None:
                given[joint.name] = (
                    joint.mimic.ratio * given[joint.mimic.joint] + joint.mimic.offset
                )
        placed = self._tree.place({**self._model.rests, **given})
        return {
            link: (_point(placed[link].child, shape_centre(self._model, link)), placed[link])
            for link in self._ends
        }

    def _pad(self, link: str, opened: Sequence[float], closed: Sequence[float]) -> Pad:
        middle = [(one + other) / 2 for one, other in zip(opened, closed, strict=True)]
        centres = self._centres(middle)
        own, at = centres[link]
        others = [centre for name, (centre, _) in centres.items() if name != link]
        normal = at.child.rotation.T @ (np.mean(others, axis=0) - own)
        normal /= np.linalg.norm(normal) or 1.0
        axis = int(np.abs(normal).argmax())
        if abs(normal[axis]) > _NEAR:
            normal = np.sign(normal) * (np.arange(3) == axis)
        mover = self._ends[link]
        index = [joint.name for joint in self._joints].index(mover)
        travel = self._centres(opened)[link][0] - self._centres(closed)[link][0]
        lever = float(np.linalg.norm(travel)) / (abs(opened[index] - closed[index]) or 1.0)
        lever = 1.0 if self._joints[index].slides else lever
        direction = tuple(round(float(each), 3) + 0.0 for each in normal)
        return Pad(link, mover, direction, lever, shape_centre(self._model, link))


def _point(pose: Pose, offset: Numbers) -> Floats:
    return np.asarray(pose.position + pose.rotation @ np.array(offset))
