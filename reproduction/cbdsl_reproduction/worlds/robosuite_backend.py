"""Backend of robosuite: its own simulation, servos and grippers, in a process of its own."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import (
    Floats,
    Image,
    Joints,
    Observation,
    Regions,
    RobotDocument,
    StageDocument,
    connected_regions,
)
from cbdsl_reproduction.worlds.camera_pair import CameraPair
from cbdsl_reproduction.worlds.robosuite_process import RobosuiteProcess

# Smallest region, px.
_LEAST_AREA = 6


class RobosuiteBackend:
    """Robot in a task of robosuite; see ``cbdsl.extend.backend.Backend``.

    The robot has encoders, cameras and load cells in its pads. No pose of an object leaves the
    process. Ideal cameras segment the objects of the task; rendered ones make images.

    Args:
        robot: Robot document of the arm.
        process: Process with the task.
        cameras: Cameras of the robot, which the process has, too.
        features: Bodies of the task that ideal cameras segment, by colour.
        kind: ``ideal`` or ``rendered``.

    Attributes:
        succeeded: Verdict of the task's own test now.
        ever_succeeded: True if the test was positive at any tick of the episode.
    """

    deadline: float | None = None

    def __init__(
        self,
        robot: RobotDocument,
        process: RobosuiteProcess,
        cameras: CameraPair,
        features: Mapping[str, Sequence[str]],
        kind: str = "ideal",
    ) -> None:
        self._robot, self._process, self._cameras = robot, process, cameras
        self._features = {name: list(bodies) for name, bodies in features.items()}
        self._kind = kind
        self.renderer = "MuJoCo" if kind == "rendered" else "nothing (ideal cameras)"
        self.control_period = 1 / robot.control.rate
        self._joints = Joints(robot)
        self._cells = [
            (hand, finger) for hand, cells in robot.load_cells.items() for finger in cells
        ]
        self._links = [robot.load_cells[hand][finger].link for hand, finger in self._cells]
        self._per_image = max(1, round(robot.control.rate / robot.vision.rate))
        self._hands = [
            (self._joints.of(hand), robot.effectors[hand].postures) for hand in robot.load_cells
        ]
        # Arms and hands are in the order of the robots of the task.
        self._arms = [
            self._joints.of(each) for each in robot.effectors if each not in robot.load_cells
        ]
        self.succeeded = self.ever_succeeded = False

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; the seed of the task is the first draw."""
        del channels
        self._process.ask("reset", seed=int(rng.integers(2**31)))
        self._tick, self.ever_succeeded = 0, False
        self._observation = self._sense()
        self._reference = self._observation.positions
        return context or next(iter(stage.contexts))

    def observe(self) -> Observation:
        """Return the current sensor values."""
        return self._observation

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,)."""
        self._reference = np.array(reference, dtype=np.float64)

    def step(self) -> None:
        """Let one control period pass."""
        self._process.ask(
            "step",
            arms=[self._reference[rows].tolist() for rows in self._arms],
            closing=[
                stroke_share(self._reference[rows], stroke["open"], stroke["closed"])
                for rows, stroke in self._hands
            ],
        )
        self._tick += 1
        self._observation = self._sense()

    def halt(self) -> None:
        """Freeze the references at the measured positions."""
        self._reference = self._observation.positions

    def close(self) -> None:
        """End the process of robosuite."""
        self._process.close()

    def _sense(self) -> Observation:
        is_exposed = self._tick % self._per_image == 0
        request: dict[str, object] = {}
        if is_exposed:
            request = {"render": True} if self._kind == "rendered" else {"label": self._features}
        values, pixels = self._process.ask(
            "read", joints=list(self._joints.names), cells=self._links, **request
        )
        self.succeeded = values["success"]
        self.ever_succeeded |= self.succeeded
        wrenches = [np.array(wrench, dtype=np.float64) for wrench in values["wrenches"]]
        return Observation(
            time=self._tick * self.control_period,
            positions=np.array(values["positions"], dtype=np.float64),
            velocities=np.array(values["velocities"], dtype=np.float64),
            loads=dict(zip(self._cells, wrenches, strict=True)),
            images=self._images(pixels) if is_exposed and self._kind == "rendered" else {},
            regions=self._regions(pixels) if is_exposed and self._kind == "ideal" else {},
        )

    def _images(self, pixels: bytes) -> dict[str, Image]:
        pair = self._cameras
        images = np.frombuffer(pixels, np.uint8).reshape(-1, pair.height, pair.width, 3)
        return dict(zip(pair.places, images, strict=True))

    def _regions(self, pixels: bytes) -> dict[str, dict[str, Regions]]:
        pair = self._cameras
        labels = np.frombuffer(pixels, np.uint8).reshape(-1, pair.height, pair.width)
        seen: dict[str, dict[str, Regions]] = {}
        for camera, image in zip(pair.places, labels, strict=True):
            seen[camera] = {}
            for number, feature in enumerate(self._features, start=1):
                regions = connected_regions(filled(image == number), _LEAST_AREA)
                if regions:
                    seen[camera][feature] = regions
        return seen


def filled(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return a mask without holes; a part with a hole, such as a nut, has its convex outline."""
    outlined = mask.astype(np.uint8)
    outlines, parents = cv2.findContours(outlined, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    for place, outline in enumerate(outlines):
        _, _, hole, parent = parents[0, place]
        if parent < 0 and hole >= 0:
            cv2.fillConvexPoly(outlined, cv2.convexHull(outline), 1)
    return outlined


def stroke_share(
    reference: Floats, opened: Sequence[float] | Floats, closed: Sequence[float] | Floats
) -> float:
    """Return the share of a stroke from open to closed that a reference asks for."""
    start, way = np.array(opened), np.array(closed) - np.array(opened)
    return float(np.clip((reference - start) @ way / (way @ way), 0.0, 1.0))
