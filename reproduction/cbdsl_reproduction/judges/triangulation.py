"""Errors of triangulated positions over the workspace.

An object is held at places over the table and above it. ``searchtrack`` finds it and brings it to
the middle of the images; then the remembered position is compared with the true one. An error is
split along the line from between the cameras to the true centre (depth, positive beyond it) and
across it. Places where a camera does not see the whole object have no position.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from cbdsl.api.control import Floats, Kinematics
from cbdsl.api.documents import RobotDocument, StageDocument
from cbdsl.api.sensing import EpisodeListeners, Runner, Tick
from cbdsl.api.shipped import shipped_program
from cbdsl.api.trials import embody_simulated
from cbdsl_reproduction.judges.judge import (
    ANY,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

_PROGRAM, _STAGE, _FEATURE = "searchtrack", "table_in_view_right", "sat_10"
# Edge of the table to beyond its middle, both halves, the table's top to above the hands' ready
# posture, m. An object that would reach into the table is put on it.
_PLACES = tuple(product((0.35, 0.55, 0.75), (-0.4, -0.2, 0.0, 0.2, 0.4), (-0.37, -0.3, -0.1, 0.2)))
_TOP = -0.42  # height of the table, m
_CAMERAS = (0.287, 0.0, 0.51)  # middle between the cameras, m
_OFF_CENTRE = 0.08  # largest angle that the head has to turn by, rad

_FORMS: Mapping[str, Mapping[str, Any]] = {
    "ball 5 cm": {"shape": "ball", "radius": 0.05},
    "ball 8 cm": {"shape": "ball", "radius": 0.08},
    "box 10 cm": {"shape": "box", "size": [0.1, 0.1, 0.1]},
}
_DISTURBED = {"image_noise": 2.0, "camera_position": 0.002, "camera_rotation": np.deg2rad(0.5)}


class SeenForm(NamedTuple):
    """Form of an object, and the images that show it.

    Attributes:
        form: Name of the form.
        times: Resolution of the cameras as a multiple of the robot's.
        is_disturbed: True for images with noise, and for cameras with errors.
    """

    form: str
    times: int = 1
    is_disturbed: bool = False


FORMS: Mapping[str, SeenForm] = {
    **{form: SeenForm(form) for form in _FORMS},
    **{f"{form}, twice the pixels": SeenForm(form, 2) for form in _FORMS},
    **{
        f"{form}, disturbed": SeenForm(form, is_disturbed=True)
        for form in ("ball 5 cm", "ball 8 cm")
    },
}


def with_resolution(robot: RobotDocument, times: int) -> RobotDocument:
    """Return the robot with a multiple of its cameras' pixels."""
    cameras = {
        name: camera.model_copy(
            update={
                "width": times * camera.width,
                "height": times * camera.height,
                "focal_length": times * camera.focal_length,
            }
        )
        for name, camera in robot.cameras.items()
    }
    return robot.model_copy(update={"cameras": cameras})


def staged(
    stage: StageDocument, seen: SeenForm, place: Sequence[float], seed: int
) -> StageDocument:
    """Return the stage with an object that is held at a place, m, shape (3,)."""
    form = _FORMS[seen.form]
    x, y, z = place
    z = max(z, _TOP + (form.get("radius") or form["size"][2] / 2))
    pan, tilt = _aim(np.array([x, y, z])) + np.random.default_rng(seed).uniform(
        -_OFF_CENTRE, _OFF_CENTRE, 2
    )
    context = {
        "things": ["thing"],
        "place": {"x": x, "y": y, "z": z, "yaw": ["-90 deg", "90 deg"], "held": True},
        "joints": {"pan": pan, "tilt": tilt},
    }
    changes = {
        "things": {"thing": {"form": form, "mass": 0.3, "color": [1, 0, 0]}},
        "contexts": {"place": context},
        "disturbance": _DISTURBED if seen.is_disturbed else {},
    }
    return StageDocument.model_validate(stage.model_dump(by_alias=True) | changes)


def _aim(point: Floats) -> Floats:
    """Return pan and tilt that look roughly at a point, rad, shape (2,)."""
    x, y, z = point - _CAMERAS
    return np.array([np.arctan2(y, x), np.arctan2(-z, np.hypot(x, y))])


def errors(position: Floats, truth: Floats, eyes: Floats) -> dict[str, float]:
    """Return the error of a position, and its parts, mm.

    Args:
        position: Remembered position, m, shape (3,).
        truth: True position, m, shape (3,).
        eyes: Middle between the cameras, m, shape (3,).
    """
    error, line = position - truth, truth - eyes
    depth = float(error @ line / np.linalg.norm(line))
    # Rounding can make the difference of squares negative.
    across = math.sqrt(max(float(error @ error) - depth**2, 0.0))
    return {
        "error_mm": 1000 * float(np.linalg.norm(error)),
        "depth_mm": 1000 * depth,
        "across_mm": 1000 * across,
    }


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each place; seeds take turns through all places."""
    seen, request = FORMS[condition.name], shipped_program(_PROGRAM, stage=_STAGE)
    robot = with_resolution(request.robot, seen.times)
    backend = embody_simulated(body.backend, robot, request.urdf, cameras=body.cameras)
    runner = Runner(robot, Kinematics(request.robot, request.urdf), request.program, backend)
    links = [camera.link for camera in robot.cameras.values()]
    last: list[Tick] = []

    def note(tick: Tick) -> None:
        last[:] = [tick]

    for seed in seeds:
        place = _PLACES[seed % len(_PLACES)]
        shown = staged(request.stage, seen, place, seed)
        result = runner.run(shown, seed, observer=EpisodeListeners(on_tick=note))
        memory, truth = last[0].signals.vision.memories[_FEATURE], backend.truth
        measures: dict[str, float] = {}
        if memory.position is not None:
            eyes = np.mean([truth.link_pose(link).position for link in links], axis=0)
            measures = errors(memory.position, truth.pose("thing").position, eyes)
            measures["remembered_radius_mm"] = 1000 * memory.radius
        outcomes = {"has a position": bool(measures)}
        yield EpisodeVerdict(seed, outcomes, result.sim_seconds, result.ending, measures)
    backend.close()


JUDGE = Judge(
    "triangulation",
    "errors of remembered positions over the workspace",
    tuple(JudgedCondition(name, _PROGRAM, {"has a position": ANY}, _STAGE) for name in FORMS),
    _measure,
    BodyChoice("bullet", "rendered"),
    episodes=len(_PLACES),
)
