"""Ready postures: the tip of serial joints can move in all directions, far from the limits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cbdsl.kinematics.coordinate_ascent import ascend
from cbdsl.kinematics.joint_tree import JointTree, PlacedJoint
from cbdsl.kinematics.pose import axis_of
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.link_place import OUTER, PLACING, at_first
from cbdsl.robot.urdf import Numbers, UrdfError, UrdfJoint, UrdfModel
from cbdsl.robot.weight import overloads

# Candidate angles: step, and largest absolute value.
_STEP = math.radians(15)
_FARTHEST = math.radians(120)
# Fewest joints that also turn it.
_TURNING = 6
_SWEEPS = 6
# Damping in parts of the squared reach. It keeps a singular direction from dominating, because
# leaving it may take two joints.
_DAMPING = 1e-4
# Smallest distance between parts of the chain that are not neighbours, and the distance along the
# chain below which parts are neighbours, both in parts of its length.
_CLEARANCE = 0.15
_NEIGHBOURHOOD = 0.3
# Share of a joint's effort that may bear the weight of links; the rest moves them.
_BEARING = 0.9
# Costs of a violation and of a turn away from zero, in logarithms of manipulability.
_FORBIDDEN = 100.0
_AWAY = 0.02


class ReadyPosture:
    """Search for a posture of serial joints, from their limits and lengths alone.

    The score is the manipulability of the tip, sqrt(det(J J^T)) (Yoshikawa 1985). It includes the
    position and, with six or more joints, the orientation. The chain avoids itself. It also stays
    above the ground if it points upwards at zero, as arms on a base do and legs do not. If the
    efforts of the model cannot hold the best posture, the best one is taken that they can hold.

    Args:
        model: Model of the robot; its other joints are at their initial positions.
        joints: Joints in series, from the root outwards.
        tip: Link beyond the last joint.
        offset: Offset of the tip in that link, m.

    Attributes:
        length: Length of the chain, from the first joint to the tip, m.
    """

    def __init__(
        self,
        model: UrdfModel,
        joints: Sequence[UrdfJoint],
        tip: str,
        offset: Numbers = (0.0, 0.0, 0.0),
    ) -> None:
        self._model, self._joints, self._offset = model, tuple(joints), np.array(offset)
        self._efforts = {joint.name: _BEARING * joint.effort for joint in self._joints}
        self._tree = JointTree(reversed(model.way(tip)))
        # Positions of all joints, of which those of the chain are replaced.
        self._positions = {j.name: at_first(j) for j in self._tree.joints if j.movable}
        self.length = sum(math.hypot(*joint.origin.xyz) for joint in self._beyond()) or 1.0
        self.length += math.hypot(*offset)
        points = self._points(self.at_first)
        self._floor = points[0][2] >= -1e-6 and points[-1][2] > points[0][2] - 0.1 * self.length

    @property
    def at_first(self) -> tuple[float, ...]:
        """Initial positions: zero if well within a joint's range, else its middle; rad or m."""
        return tuple(at_first(joint) for joint in self._joints)

    def find(self) -> tuple[float, ...]:
        """Return the best posture, or the initial one if there are too few joints.

        Returns:
            Position of each joint, rad or m.
        """
        if sum(not joint.slides for joint in self._joints) < PLACING:
            return self.at_first
        # From small to large turns, so that among equal scores the smaller turn stays.
        choices = [_choices(joint) for joint in self._joints]
        best = ascend(self.at_first, choices, self._score, _SWEEPS)[0]
        if self.can_hold(best):
            return best
        return ascend(self.at_first, choices, self._held_score, _SWEEPS)[0]

    def can_hold(self, positions: Sequence[float]) -> bool:
        """Return whether the joints' efforts bear the weight of the chain at the positions."""
        return not self._overload(positions)

    def _overload(self, positions: Sequence[float]) -> float:
        """Return the sum of the missing efforts, in parts of the joints' efforts."""
        given = {joint.name: at for joint, at in zip(self._joints, positions, strict=True)}
        try:
            over = overloads(self._model, self._positions | given, self._efforts)
        except UrdfError:
            return 0.0  # the document gets a diagnostic for it
        return math.fsum(needed / most - 1.0 for needed, most in over.values())

    def _held_score(self, positions: Sequence[float]) -> float:
        return self._score(positions) - _FORBIDDEN * self._overload(positions)

    def is_clear(self, positions: Sequence[float]) -> bool:
        """Return whether the chain avoids itself and the ground at the given positions."""
        points = self._points(positions)
        return not (self._crowded(points) or self._underground(points))

    def _beyond(self) -> list[UrdfJoint]:
        """Return the joints beyond the first one of the chain."""
        names = [joint.name for joint in self._tree.joints]
        return list(self._tree.joints[names.index(self._joints[0].name) + 1 :])

    def _score(self, positions: Sequence[float]) -> float:
        joints, points = self._place(positions)
        jacobian = self._jacobian(joints, points)
        square = jacobian.T @ jacobian + _DAMPING * np.eye(jacobian.shape[1])
        turns = math.fsum(
            abs(position) for position, joint in zip(positions, self._joints, strict=True)
            if not joint.slides
        )  # fmt: skip
        return (
            float(np.linalg.slogdet(square)[1]) / 2
            - _FORBIDDEN * (self._crowded(points) + self._underground(points))
            - _AWAY * turns
        )

    def _jacobian(self, joints: Sequence[PlacedJoint], points: Floats) -> Floats:
        """Return the motions of the tip by joint: translation, in parts of the length, and turn.

        Args:
            joints: Joints of the chain.
            points: Positions of the joints and the tip, m, shape (n + 1, 3).

        Returns:
            Row per joint, shape (n, 3), or (n, 6) if the tip can be turned, too.
        """
        slides = np.array([placed.joint.slides for placed in joints])[:, None]
        axes = np.array([placed.frame.rotation @ axis_of(placed.joint) for placed in joints])
        arms = (points[-1] - points[:-1]) / self.length
        along = np.where(slides, axes, np.cross(axes, arms))
        if len(joints) < _TURNING:
            return along
        return np.hstack([along, np.where(slides, 0.0, axes)])

    def _crowded(self, points: Floats) -> float:
        """Return the overlap of parts of the chain, in parts of its length."""
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        second, first = np.triu_indices(len(points), 1)
        far = along[first] - along[second] > _NEIGHBOURHOOD * self.length
        apart = np.linalg.norm(points[first] - points[second], axis=1) / self.length
        return float(np.maximum(0.0, _CLEARANCE - apart)[far].sum())

    def _underground(self, points: Floats) -> float:
        if not self._floor:
            return 0.0
        below = _CLEARANCE * self.length
        return float(np.maximum(0.0, below - points[-2:, 2]).sum()) / self.length

    def _points(self, positions: Sequence[float]) -> Floats:
        """Return the positions of the joints and the tip, m, shape (n + 1, 3)."""
        return self._place(positions)[1]

    def _place(self, positions: Sequence[float]) -> tuple[list[PlacedJoint], Floats]:
        """Return the chain's joints, and their positions and the tip's, m, shape (n + 1, 3)."""
        given = dict(zip((joint.name for joint in self._joints), positions, strict=True))
        way = list(self._tree.place(self._positions | given).values())
        end, joints = way[-1].child, [placed for placed in way if placed.joint.name in given]
        tip = end.position + end.rotation @ self._offset
        return joints, np.array([*(placed.frame.position for placed in joints), tip])


def _choices(joint: UrdfJoint) -> list[float]:
    """Return the candidate positions, the smallest turns first."""
    bounded = math.isfinite(joint.upper - joint.lower)
    if joint.slides:
        parts = (0.25, 0.5) if bounded else ()
        return [round(joint.lower + part * (joint.upper - joint.lower), 4) for part in parts]
    margin = OUTER * (joint.upper - joint.lower) if bounded else 0.0
    steps = range(round(-_FARTHEST / _STEP), round(_FARTHEST / _STEP) + 1)
    angles = [round(step * _STEP, 9) for step in sorted(steps, key=lambda step: (abs(step), step))]
    return [a for a in angles if joint.lower + margin <= a <= joint.upper - margin]
