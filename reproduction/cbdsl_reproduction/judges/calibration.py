"""Rewards of ``reachtouch`` without and with a calibration of the cameras, and their errors.

Ten successive seeds share a body, whose camera errors its number determines. The truth serves two
purposes only: the distance of the cameras from their assumed places, and the contact of all three
fingertips with the object in a rewarded episode.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import cbdsl
from cbdsl.api.control import Floats, Kinematics
from cbdsl.api.documents import RobotDocument
from cbdsl.api.sensing import Ray, camera_errors, triangulate
from cbdsl_reproduction.judges.judge import (
    ANY,
    NONE,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.judges.watch import Watch, watch_episode

_STAGE, _PROGRAM = "noisy_right", "reachtouch"
_SEEDS_PER_BODY, _FINGERTIPS = 10, 3
# Places on the table at which triangulation is judged, and the middle between the cameras, m.
_PLACES = [np.array((x, y, -0.35)) for x in (0.35, 0.55, 0.75) for y in (-0.4, -0.2, 0.0)]
_EYES = np.array((0.24, 0.0, 0.5))

Request = cbdsl.RunRequest
Measures = Mapping[str, float]


@cache
def request_of(body: int, backend: str, *, is_calibrated: bool) -> Request | str:
    """Return the program on a body, or the reason why the body cannot be calibrated."""
    if not is_calibrated:
        return cbdsl.load(_PROGRAM, stage=_STAGE, body=body)
    from cbdsl_calibration import calibrate

    with TemporaryDirectory() as folder:
        out = Path(folder) / "eyes.yaml"
        try:
            calibrate("dexter", out=out, body=body, seed=body, backend=backend)
        except cbdsl.UsageError as error:
            return str(error)
        return cbdsl.load(_PROGRAM, stage=_STAGE, body=body, calibration=out)


def camera_measures(request: Request) -> Measures:
    """Return the largest errors of the cameras, and of positions on the table."""
    robot = request.robot
    true = camera_errors(robot.cameras, request.stage.disturbance, np.random.default_rng())
    errors = []
    for name, camera in robot.cameras.items():
        known = camera.correction
        rotation = (0.0, 0.0, 0.0) if known is None else known.rotation
        assumed = Rotation.from_rotvec(rotation).as_matrix()
        turn = Rotation.from_matrix(assumed.T @ true[name].rotation).magnitude()
        shift = true[name].position - (0.0 if known is None else np.array(known.position))
        errors.append((1000 * float(np.linalg.norm(shift)), float(np.rad2deg(turn))))
    millimetres, degrees = zip(*errors, strict=True)
    return {
        "camera_mm": max(millimetres),
        "camera_deg": max(degrees),
        "table_mm": max(table_errors(robot, request.urdf, true)),
    }


def table_errors(robot: RobotDocument, urdf: Path, true: Mapping[str, Any]) -> list[float]:
    """Return distances of places on the table from their triangulated positions, mm.

    Args:
        robot: Robot with the corrections of its cameras.
        urdf: Model of the robot.
        true: True error of each camera.
    """
    cameras = {
        name: each.model_copy(update={"correction": None}) for name, each in robot.cameras.items()
    }
    model = Kinematics(robot.model_copy(update={"cameras": cameras}), urdf)
    believed = Kinematics(robot, urdf)
    return [_table_error(place, robot, true, model, believed) for place in _PLACES]


def _table_error(
    place: Floats,
    robot: RobotDocument,
    true: Mapping[str, Any],
    model: Kinematics,
    believed: Kinematics,
) -> float:
    # An image fixes the direction of a ray in the camera's axes: R^T (p - o), with the true
    # rotation R and origin o. The robot turns it into the world by the rotation that it assumes,
    # and lets the ray begin at the assumed origin. Errors of both cameras displace the crossing of
    # their rays.
    x, y, z = place - _EYES
    posture = np.zeros(len(model.joints))
    posture[model.joints.of("head")] = np.arctan2(y, x), np.arctan2(-z, np.hypot(x, y))
    believed.update(posture)
    model.update(posture)
    rays = []
    for name, camera in robot.cameras.items():
        here, taken = model.frame(camera.link), believed.frame(camera.link)
        rotation = here.rotation @ true[name].rotation
        origin = here.position + here.rotation @ true[name].position
        seen = taken.rotation @ rotation.T @ (place - origin)
        rays.append(Ray(taken.position, seen, float(np.linalg.norm(seen))))
    crossing = triangulate(*rays)
    assert crossing is not None, "the rays of both cameras cross"
    return 1000 * float(np.linalg.norm(crossing.position - place))


class _RewardedContacts(Watch):
    """Contacts of a rewarded hand at the end of its episode."""

    def conclude(self, result: cbdsl.EpisodeResult) -> EpisodeVerdict:
        """Return the verdict; an episode without reward has no contacts to judge."""
        touching = len(self.fingertips(*self.shown))
        outcomes = {
            "rewarded": result.rewarded,
            "rewarded without contact": touching < _FINGERTIPS if result.rewarded else None,
        }
        return EpisodeVerdict(result.seed, outcomes, result.sim_seconds, result.ending)


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode of the bodies."""
    is_calibrated = condition.name == "calibrated"
    for number in dict.fromkeys(seed // _SEEDS_PER_BODY for seed in seeds):
        own = [seed for seed in seeds if seed // _SEEDS_PER_BODY == number]
        request = request_of(number, body.backend, is_calibrated=is_calibrated)
        if isinstance(request, str):
            outcomes = {"rewarded": False, "rewarded without contact": None}
            yield from (EpisodeVerdict(seed, outcomes, 0.0, request) for seed in own)
            continue
        measures = camera_measures(request)
        with cbdsl.simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
            for seed in own:
                watch = _RewardedContacts(simulated, condition, body)
                yield watch_episode(simulated, watch, seed)._replace(measures=measures)


JUDGE = Judge(
    "calibration",
    "reaching with the camera errors of ten bodies, without and with a calibration",
    (
        JudgedCondition(
            "uncalibrated", _PROGRAM, {"rewarded": ANY, "rewarded without contact": ANY}, _STAGE
        ),
        JudgedCondition(
            "calibrated",
            _PROGRAM,
            {"rewarded": Aim(0.98), "rewarded without contact": NONE},
            _STAGE,
        ),
    ),
    _measure,
    episodes=100,
)
