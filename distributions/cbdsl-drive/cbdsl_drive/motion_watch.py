"""Motion watch: measured motion of joints, compared with the references that command it.

A program's references keep within ``control.lead`` of measured positions, so that a joint that
another controller carries along never leaves its reference far behind. Distances therefore show
little, and motion is compared.

    apart       A joint moves at one of the velocities of its references within the memory of its
                controller, which is its horizon and two control periods, and a lag. Motion faster
                or slower than all of these adds up: S = max(0, S + dq - v dt), and decays within
                seconds. A joint that an obstacle stops is not in motion.
    astray      Motion beyond all references of the memory, away from them, adds up as
                S = max(0, S + dq), until the joint is among them again. Noise and oscillations
                cancel, and slow motion counts as fast motion does.
    stuck       A joint farther than ``tracking`` from its reference does not move by half of it
                towards the reference within 0.2 s, or is three times as far.

Objects push the joints of hands that have load cells, and stop them. These may go astray by three
times ``tracking``, may move slower than their references, and may stand.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import Floats, Joints, RobotDocument
from cbdsl.extend.driver import horizon

# Time in which a joint that is far from its reference has to approach it, s.
_WINDOW = 0.2
# Motion that counts, and distances that never pass, as shares of ``tracking``.
_APART, _MOVED, _FAR = 0.3, 0.5, 3.0
# Longest lag of a joint behind its controller, time in which motion apart is forgotten, and time
# over which speeds are averaged, s.
_LAG, _FORGOTTEN, _AVERAGED = 0.1, 1.0, 0.05
# Share of the commanded speed by which a joint differs under load, share below which it is stopped,
# and speed of a joint that stands, rad/s or m/s.
_LOADED, _STOPPED, _STANDING = 0.05, 0.2, 0.02
# Share of a control period by which a reference is late, so that its controller may stand.
_LATE = 1.3


class MotionWatch:
    """Comparison of measured motion with references.

    Args:
        robot: Robot with drivers.
        period: Control period, s.

    Attributes:
        tracking: Largest distance of a joint that does not follow, rad or m, shape (n,).
    """

    def __init__(self, robot: RobotDocument, period: float) -> None:
        joints, self._period = Joints(robot), period
        self._names, count = joints.names, len(joints)
        self.tracking = np.full(count, np.inf)
        reactions = [horizon(driver, 1.0 / period) for driver in robot.drivers.values()]
        self._memory = max(reactions, default=0.0) + 2.0 * period
        for driver in robot.drivers.values():
            for effector in driver.moves:
                self.tracking[joints.pick(robot.joints(effector))] = driver.tracking
        self._is_pushed = np.zeros(count, dtype=bool)
        for hand in robot.load_cells:
            self._is_pushed[joints.pick(robot.joints(hand))] = True
        shares = np.array([[_APART], [_MOVED]])
        # Bounds of motion apart and astray, and its sums upwards and downwards, rad or m.
        self._bounds = np.where(self._is_pushed, _FAR, shares) * self.tracking
        self._sums = np.zeros((2, 2, count))
        self._references: deque[tuple[float, Floats]] = deque()
        # Velocities of references, and their times.
        self._velocities: deque[tuple[float, Floats]] = deque()
        self._before, self._stamps, self._speeds = np.zeros((3, count))
        # Sides of far references, and times and positions from which an approach is measured.
        self._side, self._since, self._from = np.zeros(count), np.zeros(count), np.zeros(count)

    def begin(self, positions: Floats, stamps: Floats, now: float) -> None:
        """Start at rest from measured positions, rad or m, shape (n,); see ``strayed``."""
        self._references = deque([(now, positions.copy())])
        self._velocities = deque([(now, np.zeros_like(positions))])
        self._before, self._stamps = positions.copy(), stamps.copy()
        self._sums[:] = self._side[:] = self._speeds[:] = 0.0

    def command(self, references: Floats, now: float) -> None:
        """Take in references that are sent at a monotonic time, rad or m, shape (n,)."""
        before, last = self._references[-1]
        if now - before > _LATE * self._period:
            self._velocities.append((now, np.zeros_like(last)))
        self._velocities.append((now, (references - last) / self._period))
        self._references.append((now, references.copy()))

    def strayed(self, positions: Floats, stamps: Floats, now: float) -> str:
        """Return the joint that moved without a command; empty if none did.

        Args:
            positions: Measured positions, rad or m, shape (n,).
            stamps: Times of the measurements by the robot's clock, s, shape (n,).
            now: Time by a monotonic clock, s.
        """
        for past, memory in ((self._references, 0.0), (self._velocities, _LAG)):
            while len(past) > 1 and past[0][0] < now - self._memory - memory:
                past.popleft()
        moved, elapsed = positions - self._before, stamps - self._stamps
        self._add_apart(moved, elapsed)
        self._add_astray(positions)
        self._before, self._stamps = positions.copy(), stamps.copy()
        away = self._sums.max(axis=1)
        beyond = np.argwhere(away > self._bounds)
        if not len(beyond):
            return ""
        rule, joint = beyond[0]
        return (
            f"joint '{self._names[joint]}' moved by {away[rule, joint]:.3f} away from its "
            f"references, and at most {self._bounds[rule, joint]:.3f} are allowed: another "
            "controller or a person moves it, its controller or watchdog has stopped, its states "
            "are frozen, or joints are exchanged"
        )

    def _add_apart(self, moved: Floats, elapsed: Floats) -> None:
        """Add motion at other velocities than those of references."""
        share = np.clip(elapsed / _AVERAGED, 0.0, 1.0)
        speeds = np.divide(moved, elapsed, out=np.zeros_like(moved), where=elapsed > 0.0)
        self._speeds += share * (speeds - self._speeds)
        commanded = np.array([velocities for _, velocities in self._velocities])
        for row, sign in enumerate((1.0, -1.0)):
            fastest, speed = (sign * commanded).max(axis=0), sign * self._speeds
            # Objects push fingers back.
            fastest = np.where(self._is_pushed, np.maximum(fastest, 0.0), fastest)
            apart = sign * moved - (fastest + _LOADED * np.abs(fastest)) * elapsed
            # A joint that is stopped on its way the other way does not move this way.
            stopped = (speed < _STANDING) & (speed > _STOPPED * fastest) & (fastest < 0.0)
            kept = self._sums[0, row] * np.exp(-elapsed / _FORGOTTEN)
            self._sums[0, row] = np.maximum(kept + np.where(stopped, 0.0, apart), 0.0)

    def _add_astray(self, positions: Floats) -> None:
        """Add motion beyond all references."""
        recent = np.array([references for _, references in self._references])
        for row, sign in enumerate((1.0, -1.0)):
            bound, at = (sign * recent).max(axis=0), sign * positions
            # Motion up to the references is commanded, and motion beyond them is not.
            beyond = at - np.maximum(sign * self._before, bound)
            sums = np.maximum(self._sums[1, row] + beyond, 0.0)
            self._sums[1, row] = np.where(at > bound, sums, 0.0)

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
