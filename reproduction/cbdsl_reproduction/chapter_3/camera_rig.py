"""Dexter, and white boxes with barcodes in front of its left camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbdsl.api.control import Floats
from cbdsl.api.documents import RobotDocument, StageDocument
from cbdsl.api.sensing import Image
from cbdsl.api.shipped import shipped_robot
from cbdsl.api.trials import SimulatedBackend, embody_simulated
from cbdsl_reproduction.chapter_3.barcode import SIZE
from cbdsl_reproduction.chapter_3.barcode_trial import FOCAL_LENGTH
from cbdsl_reproduction.simulation_fixture import REFERENCE

#: Factor by which a picture has more pixels than the source's cameras, along each axis.
FINENESS = 4

_SOURCE_CAMERA = {"width": 640, "height": 480, "focal_length": FOCAL_LENGTH}
_BOX_EDGE = 0.16
_AHEAD = {"pan": 0.0, "tilt": 0.0}


@dataclass(frozen=True)
class Placement:
    """Pose of the printed side relative to the left camera.

    Attributes:
        depth: Depth along the camera's axis, m.
        left, up: Offsets from the axis, m.
        turn: Rotation about the vertical, rad; at 0 the side is perpendicular to the axis.
    """

    depth: float
    left: float = 0.0
    up: float = 0.0
    turn: float = 0.0


def with_source_cameras(robot: RobotDocument) -> RobotDocument:
    """Return the robot with the cameras of Section 3.2: 640 x 480 pixels, focal length 837 px."""
    cameras = {
        name: camera.model_copy(update=_SOURCE_CAMERA) for name, camera in robot.cameras.items()
    }
    return robot.model_copy(update={"cameras": cameras})


class CameraRig:
    """Rig that takes pictures of boxes fixed in space.

    Attributes:
        robot: Dexter with the source's cameras.
    """

    def __init__(self, robot: RobotDocument, backend: SimulatedBackend[Any]) -> None:
        self.robot = robot
        self._backend = backend

    def baseline(self) -> float:
        """Return the distance between the two cameras, m."""
        self._backend.reset(self._stage({}, []), None, np.random.default_rng(0))
        left, right = (view.pose.position for view in self._backend.cameras.views().values())
        return float(np.linalg.norm(left - right))

    def picture(self, stripes: Sequence[float], placement: Placement) -> Image:
        """Return the view of the left camera's lens on a box.

        Args:
            stripes: Widths of bar, gap, ..., bar printed on its side, m; they are 10 cm high.
            placement: Placement of that side.

        Returns:
            RGB picture without noise, with ``FINENESS`` times the camera's pixels along each axis.
        """
        rng = np.random.default_rng(0)
        self._backend.reset(self._stage({"joints": _AHEAD}, []), None, rng)
        # The first reset turns the head; the second one places the box relative to the turned
        # camera.
        camera = self._backend.cameras.views()["left"].pose
        place = _place(camera.position, camera.rotation, placement)
        context: dict[str, object] = {
            "joints": _AHEAD,
            "things": ["box"],
            "place": {**place, "held": True},
        }
        self._backend.reset(self._stage(context, stripes), None, rng)
        return self._backend.cameras.resolve(FINENESS)["left"]

    def _stage(self, context: dict[str, object], stripes: Sequence[float]) -> StageDocument:
        pattern = {"height": SIZE, "stripes": list(stripes)} if stripes else None
        form = {"shape": "box", "size": [_BOX_EDGE] * 3, "pattern": pattern}
        return StageDocument.model_validate(
            {
                "cbdsl": 1,
                "kind": "stage",
                "name": "camera_rig",
                "robot": self.robot.name,
                "things": {"box": {"form": form, "mass": 0.3, "color": (1, 1, 1)}},
                "contexts": {"shown": context},
            }
        )


def _place(position: Floats, axes: Floats, placement: Placement) -> dict[str, float]:
    """Return the pose of the box that puts its printed side at a placement."""
    forward, left, up = axes.T
    side = position + placement.depth * forward + placement.left * left + placement.up * up
    yaw = float(np.arctan2(forward[1], forward[0])) + placement.turn
    x, y, z = side + _BOX_EDGE / 2 * np.array([np.cos(yaw), np.sin(yaw), 0.0])
    return {"x": float(x), "y": float(y), "z": float(z), "yaw": yaw}


@contextmanager
def camera_rig(engine: str = REFERENCE) -> Iterator[CameraRig]:
    """Set up Dexter on the backend of this name.

    Raises:
        BackendError: The simulator cannot embody it.
    """
    own, urdf = shipped_robot("dexter")
    robot = with_source_cameras(own)
    backend = embody_simulated(engine, robot, urdf)
    try:
        yield CameraRig(robot, backend)
    finally:
        backend.close()
