"""Sensor watch: newest wrenches, images and regions, and the reasons not to trust them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from cbdsl.extend.backend import RobotDocument
from cbdsl.extend.driver import CameraSample, Driver, ImageSample, RegionsSample, WrenchSample

Cell = tuple[str, str]
View = ImageSample | RegionsSample

# Longest time without an image, s: meanwhile the robot moves on its memory.
_BLIND = 1.0
# Largest error of a focal length, as a share.
_FOCAL = 0.02


class Arrival(NamedTuple):
    """A sample, and its time of arrival by a monotonic clock, s."""

    sample: WrenchSample | View
    time: float


class SensorWatch:
    """Newest samples of load cells and cameras.

    Args:
        robot: Robot with drivers.
        ideal: True if cameras send regions, and no images.

    Attributes:
        wrenches: Newest wrench of each load cell that a driver reads.
    """

    def __init__(self, robot: RobotDocument, *, ideal: bool) -> None:
        self._robot, self._ideal = robot, ideal
        self.wrenches: dict[Cell, WrenchSample] = {}
        self._arrivals: dict[Cell | str, float] = {}
        self._views: dict[str, View] = {}
        self._cells: dict[Cell, tuple[str, Driver]] = {}
        self._cameras: dict[str, str] = {}
        for name, driver in robot.drivers.items():
            cells = ((hand, f) for hand, fingers in driver.wrenches.items() for f in fingers)
            self._cells.update(dict.fromkeys(cells, (name, driver)))
            views = driver.regions if ideal else driver.images
            self._cameras.update(dict.fromkeys(views, name))
        # Cameras without a camera info so far, with their drivers.
        self._uninformed = {
            camera: name for name, driver in robot.drivers.items() for camera in driver.camera_info
        }

    def note_wrench(self, sample: WrenchSample, now: float) -> str:
        """Take in a wrench; return the reason why it cannot be trusted."""
        hand, finger = sample.cell
        link = self._robot.load_cells[hand][finger].link
        name = f"load cell '{hand}.{finger}'"
        if not all(math.isfinite(value) for value in sample.wrench):
            return f"driver '{sample.driver}' sends a wrench of {name} that is not finite"
        if sample.frame.removeprefix("/") != link:
            return f"{name} sends wrenches in frame '{sample.frame}' instead of link '{link}'"
        newest = self.wrenches.get(sample.cell)
        if newest is None or sample.stamp > newest.stamp:
            self.wrenches[sample.cell], self._arrivals[sample.cell] = sample, now
        return ""

    def note_view(self, sample: View, now: float) -> str:
        """Take in an image or regions; return the reason why it cannot be used."""
        if isinstance(sample, ImageSample):
            camera = self._robot.cameras[sample.camera]
            if sample.image is None:
                return (
                    f"camera '{sample.camera}' sends images in the encoding '{sample.encoding}', "
                    "and rgb8 and bgr8 are read"
                )
            height, width = sample.image.shape[:2]
            if (width, height) != (camera.width, camera.height):
                return (
                    f"camera '{sample.camera}' sends images of {width} x {height} px, and its "
                    f"document has {camera.width} x {camera.height} px"
                )
        self._views[sample.camera], self._arrivals[sample.camera] = sample, now
        return ""

    def note_camera(self, sample: CameraSample) -> str:
        """Take in a camera's intrinsic parameters; return the difference to its document."""
        camera, name = self._robot.cameras[sample.camera], sample.camera
        self._uninformed.pop(name, None)
        if (sample.width, sample.height) != (camera.width, camera.height):
            return (
                f"camera '{name}' has {sample.width} x {sample.height} px by its camera info, and "
                f"{camera.width} x {camera.height} px by its document"
            )
        for focal in sample.focal_lengths:
            if not abs(focal - camera.focal_length) <= _FOCAL * camera.focal_length:
                return (
                    f"camera '{name}' has the focal length {focal:.1f} px by its camera info, and "
                    f"{camera.focal_length:.1f} px by its document"
                )
        return ""

    def take_views(self) -> dict[str, View]:
        """Return the views since the last call, if all cameras have a new one."""
        # Stereo needs an image of each camera.
        if not self._cameras or self._views.keys() < self._cameras.keys():
            return {}
        views, self._views = self._views, {}
        return views

    def excuse(self, now: float) -> None:
        """Count the ages of all samples from now on."""
        self._arrivals = dict.fromkeys(self._arrivals, now)

    def unheard(self) -> Iterator[tuple[str, str]]:
        """Yield the address of each sensor without a message, and a sentence."""
        for cell, (name, driver) in self._cells.items():
            if cell not in self.wrenches:
                address = driver.wrenches[cell[0]][cell[1]]
                yield address, f"no wrench of load cell '{'.'.join(cell)}' from driver '{name}'"
        for camera, name in self._cameras.items():
            if camera not in self._arrivals:
                driver = self._robot.drivers[name]
                what, views = (
                    ("regions", driver.regions) if self._ideal else ("image", driver.images)
                )
                yield views[camera], f"no {what} of camera '{camera}' from driver '{name}'"
        for camera, name in self._uninformed.items():
            address = self._robot.drivers[name].camera_info[camera]
            yield address, f"no camera info of camera '{camera}' from driver '{name}'"

    def overdue(self, now: float) -> str:
        """Return the sensor whose newest sample is too old."""
        for cell, (name, driver) in self._cells.items():
            age = now - self._arrivals.get(cell, -math.inf)
            if age > driver.deadline:
                return (
                    f"no wrench of load cell '{'.'.join(cell)}' from driver '{name}' for "
                    f"{1e3 * age:.0f} ms (deadline {1e3 * driver.deadline:.0f} ms)"
                )
        for camera, name in self._cameras.items():
            age = now - self._arrivals.get(camera, -math.inf)
            if age > _BLIND:
                return f"no image of camera '{camera}' from driver '{name}' for {age:.1f} s"
        return ""
