"""Motion along a harmonic function, around obstacles (Section 3.1.2; Eq 3.2 and 7.1 to 7.5)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cbdsl.control.potential import Potential, potential
from cbdsl.control.potentials.field import HarmonicField
from cbdsl.control.potentials.grid import Grid
from cbdsl.control.setting import Setting
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Booleans, Floats
from cbdsl.program.controller import Controller

# Share of a cell by which obstacles may move without a new solution of the field.
_TOLERANCE = 0.25
# Lower bound of 1 - phi_h for its logarithm, reached inside of obstacles.
_LEAST = 1e-300


def build(controller: Controller, setting: Setting) -> Potential:
    """Return the harmonic potential of a controller, by default between its joints' limits.

    Raises:
        ValueError: If the controller has no field, or its joints have no limits.
    """
    field = controller.field
    if field is None:
        raise ValueError("a harmonic potential needs a field")
    lower = setting.lower if field.lower is None else np.array(field.lower)
    upper = setting.upper if field.upper is None else np.array(field.upper)
    circular = setting.circular if controller.feedback.type.name == "configuration" else None
    field_of = Harmonic(lower, upper, field.spacing, field.scale, field.clearance, circular)
    return field_of.potential


@potential
def displacement(
    value: Floats, reference: Floats, parameters: Floats, residual: Floats, slope: Floats
) -> float:
    """Return phi and copy the displacement, both prepared in the parameters."""
    for i in range(len(residual)):
        residual[i] = parameters[1 + i]
    phi: float = parameters[0]
    return phi


class Harmonic:
    """Bounded displacement along the gradient of phi_h, made 0 by a spring (Eq 7.1 to 7.5).

    The potential phi_h is 0 at the goal, 1 at obstacles and the border of the workspace, and
    harmonic between. It therefore has no other minimum. Its gradient fades with the distance from
    the goal, so only the direction is used. The displacement is ``scale`` times phi_h long, but at
    most the remaining distance. phi_h is solved for again if the goal moves to another cell or an
    obstacle by a quarter of a cell. The last solution is the initial one.

    The evaluation's ``phi`` is -ln(1 - phi_h). It has the same level sets as phi_h and is nearly
    equal near the goal. It falls noticeably even if phi_h differs from 1 by less than its rounding,
    and on the way out of an obstacle. The residual is the displacement, the step half of it (Eq
    7.5).

    Args:
        lower: Lower corner of the workspace, in the unit of the feedback, shape (n,), n <= 3.
        upper: Upper corner of the workspace, shape (n,).
        spacing: Spacing of the grid of phi_h, in the same unit.
        scale: Length of the displacement for phi_h = 1.
        clearance: Distance that is kept from obstacles.
        circular: True for joints whose whole turns do not count, shape (n,); their positions are
            shifted by whole turns to follow ``lower``. No path passes the seam between ``upper``
            and ``lower``, which is a border like any other. ``None`` or empty for none.

    Raises:
        ValueError: If the workspace has more than three dimensions, is unbounded or too small.
    """

    def __init__(
        self,
        lower: Floats,
        upper: Floats,
        spacing: float,
        scale: float,
        clearance: float = 0.0,
        circular: Booleans | None = None,
    ) -> None:
        self._grid = Grid.between(lower, upper, spacing)
        self._turn = np.zeros(len(lower))
        if circular is not None and len(circular):
            self._turn[circular] = 2.0 * math.pi
        self._scale = scale
        self._clearance = clearance
        self._obstacles: tuple[Obstacle, ...] = ()
        self._field: HarmonicField | None = None

    @property
    def potential(self) -> Potential:
        """Potential in the form that the tick evaluates."""
        size = len(self._grid.lower)
        parameters = np.full(1 + size, math.nan)
        return Potential(
            displacement, size, parameters=parameters, identity=True, prepare=self.prepare
        )

    def prepare(
        self, value: Floats, goal: Floats, obstacles: Sequence[Obstacle], parameters: Floats
    ) -> None:
        """Compute phi and the displacement.

        Args:
            value: Feedback, shape (n,).
            goal: Goal of the field, shape (n,).
            obstacles: Obstacles to avoid.
            parameters: Becomes phi, then the displacement, shape (1 + n,).

        Raises:
            NoPathError: If no free path leads to the goal, which may be outside of the workspace or
                inside an obstacle.
        """
        value, goal = self._in_one_turn(value), self._in_one_turn(goal)
        slope = self._solved(goal, obstacles).slope(value, goal)
        left = float(np.linalg.norm(goal - value))
        parameters[0] = -math.log(max(slope.closeness, _LEAST)) + slope.depth
        parameters[1:] = min(self._scale * slope.potential, left) * slope.direction

    def _in_one_turn(self, position: Floats) -> Floats:
        """Return a position, shape (n,), shifted by whole turns of its circular joints."""
        lower = self._grid.lower
        turns = np.floor_divide(
            position - lower, self._turn, where=self._turn > 0.0, out=np.zeros(len(lower))
        )
        shifted: Floats = position - turns * self._turn
        return shifted

    def _solved(self, goal: Floats, obstacles: Sequence[Obstacle]) -> HarmonicField:
        """Return the field for a goal and obstacles, solved again only if the last is outdated."""
        tolerance = _TOLERANCE * self._grid.spacing
        field, before = self._field, self._obstacles
        same = len(before) == len(obstacles) and not any(
            old.differs(new, tolerance) for old, new in zip(before, obstacles, strict=True)
        )
        if field is None or not same or not field.suits(goal):
            grown = [obstacle.grown(self._clearance) for obstacle in obstacles]
            field = HarmonicField(self._grid, grown, goal, field)
            self._field, self._obstacles = field, tuple(obstacles)
        return field
