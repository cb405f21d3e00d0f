"""Way back: motion of a robot from where it stands to the start of an episode.

    let go      hands open as wide as they have been; heads turn to their start
    retrace     arms return on the way that they came, without its loops
    close       hands go to their start

Configurations that the arms have passed were free of obstacles, so that this needs no model of the
scene. If the way is unknown, as in the first episode, arms rise and move straight to the start.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from cbdsl.extend.backend import Floats, Kinematics, RobotDocument
from cbdsl.extend.driver import Booleans, SelfContacts, UrdfModel
from cbdsl_drive.limiter import JointLimits

# Distance of two configurations that count as one, rad or m.
_NEAR = 0.05
# Share of the joints' largest speeds.
_PACE = 0.5
# Height by which arms rise, in steps, m; and damping of a step, m or rad.
_RISE, _STEP, _DAMPING = 0.12, 0.01, 0.05
# Distance of configurations that are examined for self-contacts, rad or m.
_EXAMINED = 0.1


class WayBack:
    """Way of a robot's arms since the start, and the motion back.

    Args:
        robot: Robot document.
        model: URDF of the robot.
        kinematics: Kinematics of the same robot.
        limits: Limits of the actuated joints.
    """

    def __init__(
        self, robot: RobotDocument, model: UrdfModel, kinematics: Kinematics, limits: JointLimits
    ) -> None:
        self._names, self._model = kinematics.joints.names, model
        self._robot, self._kinematics, self._limits = robot, kinematics, limits
        tips = [effector.tip.link for effector in robot.effectors.values() if effector.tip]
        carrying = {joint.name for tip in tips for joint in model.way(tip)}
        self._arms: Booleans = np.array([name in carrying for name in self._names], dtype=bool)
        self._closing = _closing(robot, kinematics)
        self._speed = np.minimum(_PACE * limits.velocity, robot.control.joint_speed)
        self._passed: list[Floats] = []
        # Most open position of each finger since the start, times the sign of its flexion.
        self._opened: Floats = np.full(len(self._names), np.inf)

    def begin(self, positions: Floats) -> None:
        """Begin the way at an episode's start, rad or m, shape (n,)."""
        self._passed, self._opened = [positions.copy()], self._closing * positions

    def note(self, positions: Floats) -> None:
        """Take in positions of a moving robot, rad or m, shape (n,)."""
        self._opened = np.minimum(self._opened, self._closing * positions)
        near = np.flatnonzero(self._apart(np.array(self._passed), positions) < _NEAR)
        if len(near):
            # A loop ends where the arms have been before.
            del self._passed[near[0] + 1 :]
        else:
            self._passed.append(positions.copy())

    def _apart(self, passed: Floats, positions: Floats) -> Floats:
        distances = np.abs(passed - positions)[..., self._arms]
        return np.asarray(distances.max(axis=-1, initial=0.0))

    def is_known(self, here: Floats) -> bool:
        """Return whether the way from positions to the start is known, rad or m, shape (n,)."""
        return bool(self._passed) and float(self._apart(self._passed[-1], here)) < 2.0 * _NEAR

    def points(self, here: Floats, goal: Floats) -> list[Floats]:
        """Return the configurations of the way from measured positions to a goal.

        Args:
            here: Measured positions, rad or m, shape (n,).
            goal: Start of the episode, rad or m, shape (n,).
        """
        open_hands = self._closing * np.minimum(self._closing * goal, self._opened)
        loose = np.where(self._closing != 0.0, open_hands, goal)
        between = self._passed[::-1] if self.is_known(here) else self._risen(here, goal)
        arms = [here, *between, goal]
        return [here, *(np.where(self._arms, point, loose) for point in arms), goal]

    def _risen(self, here: Floats, goal: Floats) -> list[Floats]:
        """Return the configurations in which arms away from the goal rise.

        Each step is a damped least squares solution, which keeps the orientation of the tip.
        """
        joints, kinematics = self._kinematics.joints, self._kinematics
        tips = [
            effector.tip
            for name, effector in self._robot.effectors.items()
            if effector.tip and np.abs(goal - here)[joints.of(name)].max() > _NEAR
        ]
        upwards = np.array([0.0, 0.0, _STEP, 0.0, 0.0, 0.0])
        points = [here]
        for _ in range(round(_RISE / _STEP)):
            kinematics.update(points[-1])
            step = np.zeros(len(here))
            for tip in tips:
                jacobian = kinematics.point(tip.link, tip.offset).jacobian
                square = jacobian @ jacobian.T + _DAMPING**2 * np.eye(6)
                step += jacobian.T @ np.linalg.solve(square, upwards)
            raised = points[-1] + np.where(self._arms, step, 0.0)
            points.append(np.clip(raised, self._limits.lower, self._limits.upper))
        return points[1:]

    def references(self, points: Sequence[Floats], period: float) -> Iterator[Floats]:
        """Yield references through configurations, one each control period, s."""
        for first, last in pairwise(points):
            count = int(np.ceil(np.max(np.abs(last - first) / self._speed) / period))
            for step in range(1, count + 1):
                yield first + step / count * (last - first)

    def self_contact(self, points: Sequence[Floats]) -> tuple[str, str] | None:
        """Return two links that touch between configurations, but not at their ends, if any."""
        contacts, ways = SelfContacts(self._model), [points[0]]
        for first, last in pairwise(points):
            count = int(np.ceil(np.abs(last - first).max() / _EXAMINED))
            ways += [first + step / count * (last - first) for step in range(1, count + 1)]
        pairs = [contacts.touching(dict(zip(self._names, way, strict=True))) for way in ways]
        new = frozenset().union(*pairs) - pairs[0] - pairs[-1]
        return min(new, default=None)


def _closing(robot: RobotDocument, kinematics: Kinematics) -> Floats:
    """Return 1 for joints that close a finger, -1 for opening joints, and 0 for others, (n,)."""
    closing = np.zeros(len(kinematics.joints))
    for cells in robot.load_cells.values():
        for cell in cells.values():
            jacobian = kinematics.point(cell.link, (0.0, 0.0, 0.0)).jacobian[:3]
            pressing = kinematics.frame(cell.link).rotation @ np.array(cell.normal)
            column = kinematics.joints.index[cell.joint]
            closing[column] = np.sign(pressing @ jacobian[:, column])
    return closing
