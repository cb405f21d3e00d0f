"""Ready postures: where a row of joints can move its tip every way, far from its limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from cbdsl.robot.urdf import Numbers, Rotation, UrdfJoint, UrdfModel, Vector

_Frame = tuple[Rotation, Vector]

_IDENTITY: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# Angles that are tried: multiples of this, within that of zero, and not in the outer part of a
# joint's range.
_STEP = math.radians(15)
_FARTHEST = math.radians(120)
_OUTER = 0.1
#: Fewer joints do not move a tip in three directions.
PLACING = 3
# With these it can be turned, too.
_TURNING = 6
_SWEEPS = 6
# A singular direction counts as little, not as the end of everything: it may take two joints to
# leave it. Of the squared reach.
_DAMPING = 1e-4
# How near each other parts of the row may be that are not neighbours, of its length, and below
# which share of the way between them along the row they are.
_CLEARANCE = 0.15
_NEIGHBOURHOOD = 0.3
# What a violation and a turn away from zero cost, in logarithms of manipulability.
_FORBIDDEN = 100.0
_AWAY = 0.02


class ReadyPosture:
    """Search for a posture of a row of joints, from its limits and lengths alone.

    Its score is the manipulability of the tip, sqrt(det(J J^T)) (Yoshikawa 1985): of its position,
    and with six joints or more of its orientation, too. The row keeps clear of itself, and above
    the ground where it is stretched upwards at zero, as arms on a base are and legs are not.

    Args:
        model: of the robot; its other joints are where they are at first.
        joints: in a row, from the root outwards.
        tip: a link beyond the last.
        offset: of the tip in that link, m.

    Attributes:
        length: of the row, from the first joint to the tip, m.
    """

    def __init__(
        self,
        model: UrdfModel,
        joints: Sequence[UrdfJoint],
        tip: str,
        offset: Numbers = (0.0, 0.0, 0.0),
    ) -> None:
        self._joints, self._offset = tuple(joints), offset
        self._way = _way(model, tip)
        self.length = sum(_length(joint.origin.xyz) for joint in self._beyond()) or 1.0
        self.length += _length(offset)
        at_first = self.at_first
        points = self._points(at_first)
        self._floor = points[0][2] >= -1e-6 and points[-1][2] > points[0][2] - 0.1 * self.length

    @property
    def at_first(self) -> tuple[float, ...]:
        """Zero where that is well within a joint's range, else the middle of it; rad or m."""
        return tuple(at_first(joint) for joint in self._joints)

    def find(self) -> tuple[float, ...]:
        """The best posture; that at first where there are too few joints to choose.

        Returns:
            A position per joint, rad or m.
        """
        best = self.at_first
        if sum(not joint.slides for joint in self._joints) < PLACING:
            return best
        score = self._score(best)
        for _ in range(_SWEEPS):
            before = score
            for index, joint in enumerate(self._joints):
                for position in _choices(joint):
                    tried = (*best[:index], position, *best[index + 1 :])
                    its_score = self._score(tried)
                    if its_score > score + 1e-9:
                        best, score = tried, its_score
            if score <= before:
                break
        return best

    def is_clear(self, positions: Sequence[float]) -> bool:
        """Whether the row keeps clear of itself and of the ground at some positions."""
        points = self._points(positions)
        return not (self._crowded(points) or self._underground(points))

    def tip_at(self, positions: Sequence[float]) -> Vector:
        """The position of the tip in the root's frame, m."""
        return self._points(positions)[-1]

    @property
    def shoulder(self) -> Vector:
        """The position of the first joint in the root's frame, m."""
        return self._points(self.at_first)[0]

    def _beyond(self) -> list[UrdfJoint]:
        """The joints past the first one of the row."""
        names = [joint.name for joint in self._way]
        return self._way[names.index(self._joints[0].name) + 1 :]

    def _score(self, positions: Sequence[float]) -> float:
        frames = self._frames(positions)
        points = self._points_of(frames)
        turns = math.fsum(
            abs(position) for position, joint in zip(positions, self._joints, strict=True)
            if not joint.slides
        )  # fmt: skip
        return (
            _log_determinant(self._jacobian(frames, points[-1])) / 2
            - _FORBIDDEN * (self._crowded(points) + self._underground(points))
            - _AWAY * turns
        )

    def _jacobian(self, frames: Sequence[_Frame], tip: Vector) -> list[list[float]]:
        """Motions of the tip by joint: along, in parts of the length, and about."""
        columns = []
        for joint, (rotation, place) in zip(self._joints, frames, strict=True):
            axis = _unit(_turned(rotation, joint.axis))
            arm = tuple((a - b) / self.length for a, b in zip(tip, place, strict=True))
            along = axis if joint.slides else _cross(axis, arm)
            about = (0.0, 0.0, 0.0) if joint.slides else axis
            full = len(self._joints) >= _TURNING
            columns.append([*along, *about] if full else [*along])
        return columns

    def _crowded(self, points: Sequence[Vector]) -> float:
        """How far parts of the row are into each other, in parts of its length."""
        along = [0.0]
        for one, next_one in pairwise(points):
            along.append(along[-1] + math.dist(one, next_one))
        return math.fsum(
            max(0.0, _CLEARANCE - math.dist(points[first], points[second]) / self.length)
            for first in range(len(points))
            for second in range(first)
            if along[first] - along[second] > _NEIGHBOURHOOD * self.length
        )

    def _underground(self, points: Sequence[Vector]) -> float:
        if not self._floor:
            return 0.0
        below = _CLEARANCE * self.length
        return math.fsum(max(0.0, below - z) for *_, z in points[-2:]) / self.length

    def _points(self, positions: Sequence[float]) -> list[Vector]:
        return self._points_of(self._frames(positions))

    def _points_of(self, frames: Sequence[_Frame]) -> list[Vector]:
        """Where the joints and the tip are."""
        return [*(place for _, place in frames), _placed(self._end, self._offset)]

    def _frames(self, positions: Sequence[float]) -> list[_Frame]:
        """The frames of the joints; that of the last link becomes known, too."""
        given = dict(zip((joint.name for joint in self._joints), positions, strict=True))
        frame: _Frame = (_IDENTITY, (0.0, 0.0, 0.0))
        frames: dict[str, _Frame] = {}
        for joint in self._way:
            frame = _product(frame[0], joint.origin.rotation), _placed(frame, joint.origin.xyz)
            frames[joint.name] = frame
            if joint.movable:
                frame = _moved(frame, joint, given.get(joint.name, at_first(joint)))
        self._end = frame
        return [frames[joint.name] for joint in self._joints]


def at_first(joint: UrdfJoint) -> float:
    """Zero where that is well within a joint's range, else the middle of it; rad or m."""
    margin = _OUTER * (joint.upper - joint.lower)
    if joint.endless or joint.lower + margin <= 0.0 <= joint.upper - margin:
        return 0.0
    middle = (joint.lower + joint.upper) / 2
    whole = math.radians(round(math.degrees(middle)))
    is_angle = not joint.slides and joint.lower + margin <= whole <= joint.upper - margin
    return whole if is_angle else round(middle, 4)


def _choices(joint: UrdfJoint) -> list[float]:
    """Positions to try, the smallest turns first."""
    if joint.slides:
        return [round(joint.lower + part * (joint.upper - joint.lower), 4) for part in (0.25, 0.5)]
    bounded = math.isfinite(joint.upper - joint.lower)
    margin = _OUTER * (joint.upper - joint.lower) if bounded else 0.0
    steps = range(round(-_FARTHEST / _STEP), round(_FARTHEST / _STEP) + 1)
    angles = [round(step * _STEP, 9) for step in sorted(steps, key=lambda step: (abs(step), step))]
    return [a for a in angles if joint.lower + margin <= a <= joint.upper - margin]


def _way(model: UrdfModel, link: str) -> list[UrdfJoint]:
    """The joints from the root to a link."""
    above = {joint.child: joint for joint in model.joints.values()}
    way: list[UrdfJoint] = []
    while link in above and above[link] not in way:
        way.append(above[link])
        link = above[link].parent
    return way[::-1]


def _moved(frame: _Frame, joint: UrdfJoint, position: float) -> _Frame:
    axis = _unit(joint.axis)
    if joint.slides:
        return frame[0], _placed(frame, [position * each for each in axis])
    (x, y, z), sine, cosine = axis, math.sin(position), math.cos(position)
    rest = 1.0 - cosine
    turn = (
        (cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine),
        (y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine),
        (z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest),
    )
    return _product(frame[0], turn), frame[1]


def _product(one: Rotation, other: Rotation) -> Rotation:
    columns = tuple(zip(*other, strict=True))
    x, y, z = ((_dot(row, columns[0]), _dot(row, columns[1]), _dot(row, columns[2])) for row in one)
    return x, y, z


def _turned(rotation: Rotation, vector: Sequence[float]) -> Vector:
    x, y, z = (_dot(row, vector) for row in rotation)
    return x, y, z


def _placed(frame: _Frame, vector: Sequence[float]) -> Vector:
    x, y, z = (a + b for a, b in zip(frame[1], _turned(frame[0], vector), strict=True))
    return x, y, z


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _cross(one: Sequence[float], other: Sequence[float]) -> Vector:
    (a, b, c), (x, y, z) = one, other
    return b * z - c * y, c * x - a * z, a * y - b * x


def _length(vector: Sequence[float]) -> float:
    return math.hypot(*vector)


def _unit(vector: Sequence[float]) -> Vector:
    length = _length(vector) or 1.0
    x, y, z = (each / length for each in vector)
    return x, y, z


def _log_determinant(columns: Sequence[Sequence[float]]) -> float:
    """The logarithm of the damped determinant of J J^T, by elimination."""
    size = len(columns[0])
    square = [
        [math.fsum(each[row] * each[col] for each in columns) for col in range(size)]
        for row in range(size)
    ]
    for index in range(size):
        square[index][index] += _DAMPING
    total = 0.0
    for pivot in range(size):
        head = square[pivot][pivot]
        total += math.log(head)
        for row in range(pivot + 1, size):
            factor = square[row][pivot] / head
            for col in range(pivot, size):
                square[row][col] -= factor * square[pivot][col]
    return total
