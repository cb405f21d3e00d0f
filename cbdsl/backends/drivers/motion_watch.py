"""Motion watch: measured motion of joints, compared with the references that command it.

A program's references keep within ``control.lead`` of measured positions, so that a joint that
another controller carries along never leaves its reference far behind. Distances therefore show
little, and motion is compared.

    astray      A controller moves a joint towards the references of its memory: its horizon and
                two control periods. Motion beyond all of these, away from them, adds up as a
                cumulative sum S = max(0, S + dq), until the joint is among them again. Noise and
                oscillations cancel, and slow motion counts as fast motion does.
    stuck       A joint farther than ``tracking`` from its reference does not move by half of it
                towards the reference within 0.2 s, or is three times as far.

Objects push fingers that have load cells, and stop them. These may go astray by three times
``tracking``, and may stand.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.joints import Joints
from cbdsl.robot.stopping_time import horizon

# Time in which a joint that is far from its reference has to approach it, s.
_WINDOW = 0.2
# Motion that counts, and distances that never pass, as shares of ``tracking``.
_MOVED, _FAR = 0.5, 3.0


class MotionWatch:
    """Comparison of measured motion with references.

    Args:
        robot: Robot with drivers.
        period: Control period, s.

    Attributes:
        tracking: Largest distance of a joint that does not follow, rad or m, shape (n,).
    """

    def __init__(self, robot: RobotDocument, period: float) -> None:
        joints = Joints(robot)
        self._names, count = joints.names, len(joints)
        self.tracking = np.full(count, np.inf)
        reactions = [horizon(driver, 1.0 / period) for driver in robot.drivers.values()]
        self._memory = max(reactions, default=0.0) + 2.0 * period
        for driver in robot.drivers.values():
            for effector in driver.moves:
                self.tracking[joints.pick(robot.joints(effector))] = driver.tracking
        self._is_pushed = np.zeros(count, dtype=bool)
        for cells in robot.load_cells.values():
            self._is_pushed[joints.pick([cell.joint for cell in cells.values()])] = True
        self._bounds = np.where(self._is_pushed, _FAR, _MOVED) * self.tracking
        self._references: deque[tuple[float, Floats]] = deque()
        self._before = np.zeros(count)
        # Sums of motion above and below all references, rad or m, shape (2, n).
        self._sums = np.zeros((2, count))
        # Sides of far references, and times and positions from which an approach is measured.
        self._side, self._since, self._from = np.zeros(count), np.zeros(count), np.zeros(count)

    def begin(self, positions: Floats) -> None:
        """Start at rest from measured positions, rad or m, shape (n,)."""
        self._references.clear()
        self._before = positions.copy()
        self._sums[:] = self._side[:] = 0.0

    def command(self, references: Floats, now: float) -> None:
        """Take in references that are sent at a monotonic time, rad or m, shape (n,)."""
        self._references.append((now, references.copy()))

    def astray(self, positions: Floats, now: float) -> str:
        """Return the joint that moved away from its references; empty if none did.

        Args:
            positions: Measured positions, rad or m, shape (n,).
            now: Time by a monotonic clock, s.
        """
        if not self._references:
            return ""
        while len(self._references) > 1 and self._references[0][0] < now - self._memory:
            self._references.popleft()
        recent = np.array([references for _, references in self._references])
        before, self._before = self._before, positions.copy()
        for row, sign in enumerate((1.0, -1.0)):
            bound, at = (sign * recent).max(axis=0), sign * positions
            # Motion up to the references is commanded, and motion beyond them is not.
            moved = at - np.maximum(sign * before, bound)
            sums = np.maximum(self._sums[row] + moved, 0.0)
            self._sums[row] = np.where(at > bound, sums, 0.0)
        away = self._sums.max(axis=0)
        far = np.flatnonzero(away > self._bounds)
        if not len(far):
            return ""
        joint = int(far[0])
        return (
            f"joint '{self._names[joint]}' moved by {away[joint]:.3f} away from its references, "
            f"and at most {self._bounds[joint]:.3f} are allowed: another controller or a person "
            "moves it, or joints are exchanged"
        )

    def lagging(self, references: Floats, positions: Floats) -> NDArray[np.bool_]:
        """Return the joints that are far from their references, shape (n,)."""
        far: NDArray[np.bool_] = np.abs(references - positions) > self.tracking
        return far

    def stuck(self, references: Floats, positions: Floats, now: float) -> str:
        """Return the joint that does not follow its reference; empty if all do.

        Args:
            references: Newest references, rad or m, shape (n,).
            positions: Measured positions, rad or m, shape (n,).
            now: Time by a monotonic clock, s.
        """
        distances = np.abs(references - positions)
        far = self.lagging(references, positions) & ~self._is_pushed
        side = np.where(far, np.sign(references - positions), 0.0)
        approached = side * (positions - self._from) >= _MOVED * self.tracking
        anew = (side != self._side) | approached
        self._side = side
        self._since[anew], self._from[anew] = now, positions[anew]
        is_late = far & (now - self._since > _WINDOW)
        late = np.flatnonzero(is_late | (distances > _FAR * self.tracking))
        if not len(late):
            return ""
        joint = int(late[0])
        return (
            f"joint '{self._names[joint]}' is {distances[joint]:.3f} from its reference and does "
            f"not follow it (at most {self.tracking[joint]:.3f} for {1e3 * _WINDOW:.0f} ms)"
        )
