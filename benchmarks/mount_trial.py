"""One mount judged: whether the hands come together there, what they reach, and what is in view."""

from __future__ import annotations

import math
from dataclasses import asdict
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from arm_mount import ArmMount
from mounted_arms import RADIUS, TABLE, Meeting, MountedArms

from cbdsl.documents.robot import RobotDocument

#: Where things are taken: twelve places of the right half of the table, m.
GRASPS = tuple(product((0.37, 0.49, 0.61, 0.73), (-0.38, -0.21, -0.04)))
#: Where things may stand: thirty places of both halves, m.
PLACES = tuple(product((0.35, 0.45, 0.55, 0.65, 0.75), (-0.40, -0.24, -0.08, 0.08, 0.24, 0.40)))
# A resting posture that the arm does not have, as a sum of errors, m and a tenth of rad.
_UNFIT = 0.05
# Palms that are farther apart are no nearer to meeting, and things so far from where a hand
# would close are not about to be in it, m.
_FAR, _WIDE, _IN_HAND = 0.50, 0.30, 0.05
_WORSE = 0.02


class MountTrial(NamedTuple):
    """What became of one mount.

    Attributes:
        number: of the trial.
        jacobian: that the manipulability was of.
        mount: of the arms.
        grasps: of ``GRASPS``, how many the right hand could take.
        near: share of ``GRASPS`` after which the palms' tips come within reach of a touch.
        together: the same, with no arm in the table or in the other one.
        apart: distances of the tips after grasps, m, in the order of ``GRASPS``.
        aim: median distance of the thing from where the other hand would close, m.
        reach: share of ``PLACES`` that a hand reaches with the palm down.
        view: share of ``PLACES`` that both cameras see past the resting arms.
        seen: share of the grasps after which both cameras see the thing past the arms.
        phi: median localizability of the thing where it is in both images, m^2/rad^2.
        score: that the search climbs.
    """

    number: int
    jacobian: str
    mount: dict[str, float]
    grasps: int = 0
    near: float = 0.0
    together: float = 0.0
    apart: tuple[float, ...] = ()
    aim: float = math.nan
    reach: float = 0.0
    view: float = 0.0
    seen: float = 0.0
    phi: float = math.nan
    score: float = -1.0


def judge(
    number: int,
    mount: ArmMount,
    jacobian: str,
    robot: RobotDocument,
    today: MountTrial | None = None,
) -> MountTrial:
    """Take, bring together, reach and look.

    Args:
        number: of the trial.
        mount: that is tried.
        jacobian: that the manipulability is of.
        robot: Dexter.
        today: reach and view that the search is not to lose; ``None`` for none.
    """
    arms = MountedArms(robot, mount)
    trial = MountTrial(number, jacobian, asdict(mount))
    if arms.unfit > _UNFIT:
        return trial
    meetings = []
    for place in GRASPS:
        if arms.reach(place).arrived:
            meetings.append(arms.bring_together(jacobian))
    reached = sum(arms.reach(place).arrived for place in PLACES)
    arms.rest()
    in_view = sum(
        arms.sees(np.array((*place, TABLE + RADIUS)), held=())[0] for place in PLACES
    )
    phis = [meeting.phi for meeting in meetings if not math.isnan(meeting.phi)]
    trial = trial._replace(
        grasps=len(meetings),
        near=_share(sum(meeting.near for meeting in meetings)),
        together=_share(sum(meeting.together for meeting in meetings)),
        apart=tuple(round(meeting.apart, 4) for meeting in meetings),
        aim=float(np.median([m.aim for m in meetings])) if meetings else math.nan,
        reach=reached / len(PLACES),
        view=in_view / len(PLACES),
        seen=_share(sum(meeting.seen for meeting in meetings)),
        phi=float(np.median(phis)) if phis else math.nan,
    )
    return trial._replace(score=_score(trial, meetings, today))


def _share(count: int) -> float:
    return count / len(GRASPS)


def _score(trial: MountTrial, meetings: list[Meeting], today: MountTrial | None) -> float:
    """Mean nearness of the hands after grasps, less what is lost of reach and view."""
    total = sum(_nearness(meeting) for meeting in meetings) / len(GRASPS)
    if today is not None:
        for kept, before in ((trial.reach, today.reach), (trial.view, today.view)):
            total -= 2.0 * max(0.0, before - _WORSE - kept)
    return float(total)


def _nearness(meeting: Meeting) -> float:
    """1 where the hands are together, and up to a half more the better the other one can close."""
    near = min(1.0, max(0.0, (_FAR - meeting.apart) / (_FAR - 0.15)))
    aim = min(1.0, max(0.0, (_WIDE - meeting.aim) / (_WIDE - _IN_HAND)))
    possible = 1.0 if meeting.possible else 0.5
    return possible * (near + 0.3 * aim + 0.2 * meeting.seen)


def describe(trial: MountTrial) -> dict[str, Any]:
    """A trial as a row of JSON, NaN as null."""
    return {
        key: None if isinstance(value, float) and math.isnan(value) else value
        for key, value in trial._asdict().items()
    }
