"""How far triangulated positions are from the truth, over the workspace.

A ball or a box is held at places over the table and above it. ``searchtrack`` finds it and brings
it to the middle of the rendered images; then the position that the robot remembers is compared
with the simulator's. Errors are split along the line from between the cameras to the true centre
(depth, positive beyond it) and across it. Places where a camera does not see the whole thing have
no position, and are counted.

    python benchmarks/triangulation.py [--only "ball 5 cm"] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

from cbdsl.api.shipped import shipped_robot
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library, shipped

# Edge of the table to beyond its middle, both halves, the table's top to above the hands' ready
# posture, m. An object that would reach into the table is put on it.
_PLACES = tuple(product((0.35, 0.55, 0.75), (-0.4, -0.2, 0.0, 0.2, 0.4), (-0.37, -0.3, -0.1, 0.2)))
_QUICK_PLACES = _PLACES[::7]
_TOP = -0.42  # of the table, m
_CAMERAS = (0.287, 0.0, 0.51)  # the middle between the cameras, m: where the head is to look from
_OFF_CENTRE = 0.08  # rad, largest angle that the head has to turn by

_FORMS: dict[str, dict[str, Any]] = {
    "ball 5 cm": {"shape": "ball", "radius": 0.05},
    "ball 8 cm": {"shape": "ball", "radius": 0.08},
    "box 10 cm": {"shape": "box", "size": [0.1, 0.1, 0.1]},
}
_DISTURBED = {"image_noise": 2.0, "camera_position": 0.002, "camera_rotation": np.deg2rad(0.5)}


@dataclass(frozen=True)
class Condition:
    """A thing, the cameras' resolution as a multiple of the robot document's, and imperfections."""

    form: str
    times: int = 1
    disturbed: bool = False


@dataclass(frozen=True)
class Sighting:
    """The estimated place and size of the thing, and its true place, m."""

    position: Floats
    radius: float
    truth: Floats
    eyes: Floats

    @property
    def error(self) -> Floats:
        """Taken less true position, shape (3,)."""
        return self.position - self.truth

    @property
    def depth(self) -> float:
        """The error's part along the line of sight."""
        line = self.truth - self.eyes
        return float(self.error @ line / np.linalg.norm(line))

    @property
    def across(self) -> float:
        """The size of its other part."""
        square = float(self.error @ self.error) - self.depth**2
        return math.sqrt(max(square, 0.0))


CONDITIONS = (
    *(Condition(form, times) for times in (1, 2) for form in _FORMS),
    *(Condition(form, disturbed=True) for form in ("ball 5 cm", "ball 8 cm")),
)


class SimulatedRobot:
    """The robot with cameras of some resolution, on the simulator."""

    def __init__(self, times: int) -> None:
        library = Library(shipped())
        robot, urdf = shipped_robot("dexter", library)
        self._robot = _with_resolution(robot, times)
        self._backend = BulletBackend(self._robot, urdf)
        program = check_program("searchtrack", {}, library)
        self._runner = Runner(self._robot, Kinematics(robot, urdf), program, self._backend)
        file = library.find(StageDocument, "table_in_view_right")
        assert file is not None
        self._stage = library.read(file, StageDocument).document
        self.size = "x".join(str(s) for s in _size(self._robot))

    def look(self, condition: Condition, place: tuple[float, ...], seed: int) -> Sighting | None:
        """Centre an object, and return the robot's estimate of its place."""
        last: list[Tick] = []

        def note(tick: Tick) -> None:
            last[:] = [tick]

        self._runner.run(
            self._staged(condition, place, seed), seed, observer=EpisodeListeners(on_tick=note)
        )
        memory = last[0].signals.vision.memories["sat_10"]
        if memory.position is None:
            return None
        truth = self._backend.truth
        eyes = [truth.link_pose(camera.link).position for camera in self._robot.cameras.values()]
        return Sighting(
            memory.position, memory.radius, truth.pose("thing").position, np.mean(eyes, axis=0)
        )

    def _staged(self, condition: Condition, place: tuple[float, ...], seed: int) -> StageDocument:
        form = _FORMS[condition.form]
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
            "disturbance": _DISTURBED if condition.disturbed else {},
        }
        return StageDocument.model_validate(self._stage.model_dump(by_alias=True) | changes)

    def close(self) -> None:
        """End the simulation."""
        self._backend.close()


def _with_resolution(robot: RobotDocument, times: int) -> RobotDocument:
    cameras = {
        name: Camera(
            link=camera.link,
            width=times * camera.width,
            height=times * camera.height,
            focal_length=times * camera.focal_length,
        )
        for name, camera in robot.cameras.items()
    }
    return robot.model_copy(update={"cameras": cameras})


def _size(robot: RobotDocument) -> tuple[int, int]:
    camera = next(iter(robot.cameras.values()))
    return camera.width, camera.height


def _aim(point: Floats) -> Floats:
    """Return pan and tilt that look roughly at a point."""
    x, y, z = point - _CAMERAS
    return np.array([np.arctan2(y, x), np.arctan2(-z, np.hypot(x, y))])


def summarise(condition: Condition, size: str, sightings: list[Sighting | None]) -> dict[str, Any]:
    """Return one row of the table; lengths in mm."""
    seen = [sighting for sighting in sightings if sighting is not None]
    row: dict[str, Any] = asdict(condition) | {"size": size}
    row |= {"places": len(sightings), "positions": len(seen)}
    if not seen:
        return row
    errors = 1000 * np.array([sighting.error for sighting in seen])
    depths = 1000 * np.array([sighting.depth for sighting in seen])
    across = 1000 * np.array([sighting.across for sighting in seen])
    radius = _FORMS[condition.form].get("radius")
    worst = seen[int(np.argmax(np.linalg.norm(errors, axis=1)))]
    return row | {
        "mean": errors.mean(axis=0).round(2).tolist(),
        "std": errors.std(axis=0).round(2).tolist(),
        "largest": round(float(np.linalg.norm(errors, axis=1).max()), 1),
        "largest_at": worst.truth.round(2).tolist(),
        "depth_mean": round(float(depths.mean()), 2),
        "depth_std": round(float(depths.std()), 2),
        "depth_largest": round(float(np.abs(depths).max()), 1),
        "across_mean": round(float(across.mean()), 2),
        "across_largest": round(float(across.max()), 1),
        "remembered_radius": _spread([1000 * sighting.radius for sighting in seen]),
        "radius": None if radius is None else 1000 * radius,
    }


def _spread(values: list[float]) -> list[float]:
    """Return least, mean and largest."""
    return [round(float(each), 1) for each in (min(values), np.mean(values), max(values))]


def rows(only: str | None, places: tuple[tuple[float, ...], ...]) -> Iterator[dict[str, Any]]:
    """Yield the table, row by row."""
    for times in (1, 2):
        simulated = SimulatedRobot(times)
        for condition in CONDITIONS:
            if condition.times == times and only in (None, condition.form):
                sightings = [simulated.look(condition, at, seed) for seed, at in enumerate(places)]
                yield summarise(condition, simulated.size, sightings)
        simulated.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", choices=_FORMS, help="one thing")
    parser.add_argument("--quick", action="store_true", help="every seventh place")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if not options.json:
        print(
            "| thing | images | positions | mean error x, y, z | std | largest | depth | "
            "across | remembered radius |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
        )
    for row in rows(options.only, _QUICK_PLACES if options.quick else _PLACES):
        print(json.dumps(row) if options.json else _line(row), flush=True)


def _line(row: dict[str, Any]) -> str:
    images = row["size"] + (", disturbed" if row["disturbed"] else "")
    begin = f"| {row['form']} | {images} | {row['positions']} of {row['places']} "
    if not row["positions"]:
        return begin + "| - " * 6 + "|"
    mean, std = (", ".join(f"{each:.1f}" for each in row[key]) for key in ("mean", "std"))
    least, middle, most = row["remembered_radius"]
    return begin + (
        f"| {mean} | {std} | {row['largest']:.1f} "
        f"| {row['depth_mean']:.1f} ± {row['depth_std']:.1f}, at most {row['depth_largest']:.1f} "
        f"| {row['across_mean']:.1f}, at most {row['across_largest']:.1f} "
        f"| {middle:.1f} ({least:.1f} to {most:.1f}) |"
    )


if __name__ == "__main__":
    main()
