"""Sensor watch: wrenches, images and camera info that cannot be trusted, or are overdue."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from cbdsl.api.reading.robots import read_robot
from cbdsl.backends.backend import BackendError
from cbdsl.documents.robot import RobotDocument
from cbdsl.extend.driver import CameraSample, ImageSample, RegionsSample, WrenchSample
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_drive.backend import DrivenBackend
from cbdsl_drive.safety_supervisor import SafetySupervisor, State
from cbdsl_drive.sensor_watch import SensorWatch

CELL = ("left_hand", "finger_1")


@cache
def dexter() -> RobotDocument:
    return read_robot("dexter")[0]


def wrench(**changes: object) -> WrenchSample:
    link = dexter().load_cells["left_hand"]["finger_1"].link
    return WrenchSample("body", CELL, 1.0, link, (0.0,) * 6)._replace(**changes)


def image(camera: str = "left", shape: tuple[int, ...] | None = None) -> ImageSample:
    section = dexter().cameras[camera]
    size = shape or (section.height, section.width, 3)
    return ImageSample("body", camera, 1.0, np.zeros(size, dtype=np.uint8))


def info(**changes: object) -> CameraSample:
    section = dexter().cameras["left"]
    focal = section.focal_length
    sample = CameraSample("body", "left", section.width, section.height, (focal, focal))
    return sample._replace(**changes)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({}, ""),
        (
            {"wrench": (0.0, 0.0, 0.0, 0.0, 0.0, math.nan)},
            "'left_hand.finger_1' that is not finite",
        ),
        ({"wrench": (math.inf, 0.0, 0.0, 0.0, 0.0, 0.0)}, "that is not finite"),
        ({"frame": "world"}, "sends wrenches in frame 'world' instead of link"),
        ({"frame": ""}, "sends wrenches in frame '' instead of link"),
    ],
)
def test_sensor_watch_distrusts_a_wrench(changes: dict[str, object], problem: str) -> None:
    sensors = SensorWatch(dexter(), ideal=True)
    found = sensors.note_wrench(wrench(**changes), 0.0)
    assert (problem in found) if problem else (found == "")
    assert (CELL in sensors.wrenches) is not bool(problem)


def test_sensor_watch_keeps_the_newest_wrench_and_its_age() -> None:
    sensors = SensorWatch(dexter(), ideal=True)
    for now, stamp in ((0.0, 1.0), (0.1, 0.9), (0.2, 1.0)):
        sensors.note_wrench(wrench(stamp=stamp), now)
    assert sensors.wrenches[CELL].stamp == 1.0
    # A stamp that stands still is no new measurement.
    assert "load cell 'left_hand.finger_1' from driver 'body' for 200 ms" in sensors.overdue(0.2)


@pytest.mark.parametrize(("age", "late"), [(0.045, False), (0.055, True)])
def test_wrench_is_overdue_after_the_deadline(age: float, late: bool) -> None:
    sensors = SensorWatch(dexter(), ideal=True)
    for hand, cells in dexter().load_cells.items():
        for finger, cell in cells.items():
            sensors.note_wrench(wrench(cell=(hand, finger), frame=cell.link), 0.0)
    sensors.note_view(RegionsSample("body", "left", 1.0, {}), 0.0)
    sensors.note_view(RegionsSample("body", "right", 1.0, {}), 0.0)
    assert sensors.overdue(age).startswith("no wrench") is late
    sensors.excuse(age)
    assert sensors.overdue(2 * age - 0.02) == "", "ages count from the excuse"


@pytest.mark.parametrize(("age", "late"), [(0.95, False), (1.05, True)])
def test_image_is_overdue_after_a_second(age: float, late: bool) -> None:
    robot = dexter()
    body = robot.drivers["body"].model_copy(update={"wrenches": {}})
    sensors = SensorWatch(robot.model_copy(update={"drivers": {"body": body}}), ideal=False)
    for camera in ("left", "right"):
        assert sensors.note_view(image(camera), 0.0) == ""
    sensors.note_view(image("right"), age)
    assert sensors.overdue(age).startswith("no image of camera 'left'") is late


def test_supervisor_holds_a_robot_whose_wrench_is_overdue() -> None:
    robot, urdf = read_robot("dexter")
    supervisor = SafetySupervisor(robot, read_urdf(urdf), 1.0 / 60.0, ideal=True)
    supervisor.make_ready(0.0)
    # No joint is heard either, so the cause may be any of the two; the joints are excused here.
    supervisor.joints.overdue = lambda now: ""  # type: ignore[method-assign]
    supervisor.check(0.01)
    assert supervisor.state is State.HELD
    assert supervisor.cause.startswith("no wrench of load cell")


def test_supervisor_counts_ages_from_the_end_of_a_long_tick() -> None:
    robot, urdf = read_robot("dexter")
    supervisor = SafetySupervisor(robot, read_urdf(urdf), 1.0 / 60.0, ideal=True)
    for hand, cells in robot.load_cells.items():
        for finger, cell in cells.items():
            supervisor.note(wrench(cell=(hand, finger), frame=cell.link), 0.0, 0.0)
    for camera in robot.cameras:
        supervisor.note(RegionsSample("body", camera, 1.0, {}), 0.0, 0.0)
    supervisor.joints.overdue = lambda now: ""  # type: ignore[method-assign]
    supervisor.make_ready(0.0)
    supervisor.resume(0.3)
    supervisor.check(0.31)
    assert supervisor.state is State.READY
    supervisor.check(0.36)
    assert supervisor.state is State.HELD


def test_views_are_taken_when_each_camera_has_a_new_one() -> None:
    sensors = SensorWatch(dexter(), ideal=False)
    sensors.note_view(image("left"), 0.0)
    assert sensors.take_views() == {}
    sensors.note_view(image("right"), 0.0)
    assert set(sensors.take_views()) == {"left", "right"}
    assert sensors.take_views() == {}


def test_image_of_another_size_or_encoding_is_distrusted() -> None:
    sensors = SensorWatch(dexter(), ideal=False)
    assert "sends images of 4 x 2 px" in sensors.note_view(image(shape=(2, 4, 3)), 0.0)
    unread = image()._replace(image=None, encoding="mono8")
    assert "in the encoding 'mono8', and rgb8 and bgr8 are read" in sensors.note_view(unread, 0.0)
    assert sensors.take_views() == {}


@pytest.mark.parametrize(
    ("share", "differs"), [(1.019, False), (1.021, True), (0.979, True), (math.nan, True)]
)
def test_camera_info_with_another_focal_length_differs(share: float, differs: bool) -> None:
    sensors, focal = SensorWatch(dexter(), ideal=False), dexter().cameras["left"].focal_length
    found = sensors.note_camera(info(focal_lengths=(focal, share * focal)))
    assert ("has the focal length" in found) is differs


def test_camera_info_with_another_size_differs() -> None:
    found = SensorWatch(dexter(), ideal=False).note_camera(info(width=1))
    assert found.startswith("camera 'left' has 1 x ")


@pytest.mark.parametrize("ideal", [False, True])
def test_robot_of_which_one_camera_is_not_read_is_refused(ideal: bool) -> None:
    robot, urdf = read_robot("dexter")
    key = "regions" if ideal else "images"
    views = {"left": getattr(robot.drivers["body"], key)["left"]}
    body = robot.drivers["body"].model_copy(update={key: views})
    partial = robot.model_copy(update={"drivers": {"body": body}})
    with pytest.raises(BackendError, match="no driver reads camera 'right'"):
        DrivenBackend(partial, urdf, cameras="ideal" if ideal else None)


def test_robot_of_which_one_effector_is_not_moved_is_refused() -> None:
    robot, urdf = read_robot("dexter")
    moves = tuple(name for name in robot.drivers["body"].moves if name != "left_arm")
    body = robot.drivers["body"].model_copy(update={"moves": moves})
    partial = robot.model_copy(update={"drivers": {"body": body}})
    with pytest.raises(BackendError, match="no driver of robot 'dexter' moves effector 'left_arm'"):
        DrivenBackend(partial, urdf)
