"""Judgement of one mount: the meeting of the hands, their reach, and the view."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from typing import NamedTuple

import numpy as np

from cbdsl.api.documents import RobotDocument
from cbdsl_reproduction.mounts.arm_mount import ArmMount
from cbdsl_reproduction.mounts.mounted_arms import RADIUS, TABLE, TOGETHER, MountedArms

Place = tuple[float, float]

#: Places where objects are taken: twelve places of the right half of the table, m.
GRASPS: tuple[Place, ...] = tuple(product((0.37, 0.49, 0.61, 0.73), (-0.38, -0.21, -0.04)))
#: Places where objects may stand: thirty places of both halves, m.
PLACES: tuple[Place, ...] = tuple(
    product((0.35, 0.45, 0.55, 0.65, 0.75), (-0.40, -0.24, -0.08, 0.08, 0.24, 0.40))
)
# A resting posture that the arm does not have, as a sum of errors, m and a tenth of rad.
_UNFIT = 0.05
# Palms that are farther apart are no nearer to meeting, and things so far from where a hand
# would close are not about to be in it, m.
_FAR, _WIDE, _IN_HAND = 0.50, 0.30, 0.03
_WORSE = 0.02


class MountTrial(NamedTuple):
    """Outcome of one mount; grasps are in the order of ``GRASPS``.

    Attributes:
        number: Number of the trial.
        jacobian: Jacobian of the manipulability.
        mount: Mount of the arms.
        apart: Distances of the tips after each grasp, m.
        aims: Distances of the object from the place where the other hand would close, m.
        possible: True if no arm went into the table or into the other one.
        seen: True if both cameras see the object past the arms.
        phis: Localizability of the object, m^2/rad^2; NaN if it is not in both images.
        reach: Share of ``PLACES`` that a hand reaches with the palm down.
        view: Share of ``PLACES`` that both cameras see past the resting arms.
        tried: Number of grasps tried.
    """

    number: int
    jacobian: str
    mount: Mapping[str, float]
    apart: Sequence[float] = ()
    aims: Sequence[float] = ()
    possible: Sequence[bool] = ()
    seen: Sequence[bool] = ()
    phis: Sequence[float] = ()
    reach: float = 0.0
    view: float = 0.0
    tried: int = len(GRASPS)

    @property
    def near(self) -> float:
        """Share of the grasps after which the tips come within reach of a touch."""
        return sum(apart < TOGETHER for apart in self.apart) / self.tried

    @property
    def together(self) -> float:
        """The same, with no arm in the table or in the other one."""
        pairs = zip(self.apart, self.possible, strict=True)
        return sum(apart < TOGETHER and possible for apart, possible in pairs) / self.tried

    @property
    def in_view(self) -> float:
        """Share of the grasps after which both cameras see the thing."""
        return sum(self.seen) / self.tried

    @property
    def phi(self) -> float:
        """Median localizability of the things in both images, m^2/rad^2; NaN without any."""
        return _median([phi for phi in self.phis if not math.isnan(phi)])

    @property
    def distance(self) -> float:
        """Median distance of the tips, m; NaN without any grasp."""
        return _median(self.apart)

    @property
    def aim(self) -> float:
        """Median distance of the thing from where the other hand would close, m."""
        return _median(self.aims)

    def score(self, today: MountTrial) -> float:
        """Return the objective: nearness of the hands, less the losses of reach and view."""
        total = sum(map(_nearness, self.apart, self.aims, self.possible, self.seen)) / self.tried
        # A loss below 2 %, less than one of the thirty places, is free. A larger one weighs double.
        for kept, before in ((self.reach, today.reach), (self.view, today.view)):
            total -= 2.0 * max(0.0, before - _WORSE - kept)
        return total


def judge(
    number: int,
    mount: ArmMount,
    jacobian: str,
    robot: RobotDocument,
    grasps: Sequence[Place] = GRASPS,
    places: Sequence[Place] = PLACES,
    hands: Sequence[str] = ("right",),
) -> MountTrial:
    """Take objects, bring the hands together, and measure reach and view.

    Args:
        number: Number of the trial.
        mount: Mount to judge.
        jacobian: Jacobian of the manipulability.
        robot: Robot document of Dexter.
        grasps: Places at which objects are taken, m.
        places: Places at which they may stand, m.
        hands: Hands whose reach counts; one is the other's mirror image.
    """
    arms = MountedArms(robot, mount)
    trial = MountTrial(number, jacobian, asdict(mount), tried=len(grasps))
    # Grasps begin in the resting posture, so that the trial of an unfit mount stays empty.
    if arms.unfit > _UNFIT:
        return trial
    # ``reach`` moves the arm, and the ascent begins in the posture at the end of the reach.
    meetings = [arms.bring_together(jacobian) for place in grasps if arms.reach(place).arrived]
    reached = sum(arms.reach(place, hand).arrived for place in places for hand in hands)
    arms.rest()
    points = [np.array((*place, TABLE + RADIUS)) for place in places]
    in_view = sum(arms.sees(point, held=())[0] for point in points)
    return trial._replace(
        apart=[round(meeting.apart, 4) for meeting in meetings],
        aims=[round(meeting.aim, 4) for meeting in meetings],
        possible=[meeting.possible for meeting in meetings],
        seen=[meeting.seen for meeting in meetings],
        phis=[round(meeting.phi, 4) for meeting in meetings],
        reach=reached / len(places) / len(hands),
        view=in_view / len(places),
    )


def anywhere(count: int, sides: tuple[float, float], rng: np.random.Generator) -> list[Place]:
    """Return places of the table between two distances to the left of its middle, m."""
    xs, ys = rng.uniform(0.35, 0.75, count), rng.uniform(*sides, count)
    return list(zip(xs.tolist(), ys.tolist(), strict=True))


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _nearness(apart: float, aim: float, possible: bool, seen: bool) -> float:
    """Return 2 if the hands are together, the object is at the other's grasp, and it is seen."""
    # Ramps rank mounts whose hands are still apart. A mere count of meetings is 0 for most of them.
    near = min(1.0, max(0.0, (_FAR - apart) / (_FAR - TOGETHER)))
    aimed = min(1.0, max(0.0, (_WIDE - aim) / (_WIDE - _IN_HAND)))
    return (1.0 if possible else 0.5) * (0.8 * near + aimed + 0.2 * seen)
