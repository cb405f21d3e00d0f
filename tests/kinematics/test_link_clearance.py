"""Distances of links: by other code, in each posture of a motion, with their slopes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import ClearanceSection, HullSection, RobotDocument
from cbdsl.kinematics.link_clearance import LinkClearance, too_near_at_start, with_places
from cbdsl.kinematics.link_shapes import link_shapes
from cbdsl.kinematics.self_contacts import SelfContacts
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf

LEAST, NEAR = 0.02, 0.1  # m


@pytest.fixture(scope="module")
def model(urdf: Path) -> UrdfModel:
    return read_urdf(urdf)


def moved(links: LinkClearance, count: int) -> list[Floats]:
    """Return a random walk of all joints from the start posture."""
    rng, at, walk = np.random.default_rng(1), links.start, list[Floats]()
    speed = np.zeros(len(at))
    for tick in range(count):
        if tick % 30 == 0:
            speed = rng.normal(size=len(at)) * 0.03
        at = np.clip(at + speed, -2.5, 2.5)
        walk.append(at)
    return walk


def test_distances_along_a_motion_equal_those_of_each_posture_alone(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    links = LinkClearance(dexter, model, LEAST, NEAR)
    for posture in moved(links, 120)[::4]:
        links.measure(posture)
        found = links.arrays.pairs.copy()

        links.arrays.pairs["distance"], links.arrays.at[:] = -1.0, np.nan
        links.measure(posture)
        exact = links.arrays.pairs
        assert (found["near"] == exact["near"]).all()
        near = exact["near"]
        assert found["distance"][near] == pytest.approx(exact["distance"][near], abs=1e-9)


def test_slopes_of_near_pairs_are_the_differences_of_their_distances(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    links, right = LinkClearance(dexter, model, LEAST, NEAR), list[bool]()
    for posture in moved(links, 400)[::40]:
        links.measure(posture)
        pairs = links.arrays.pairs
        for number in np.flatnonzero(pairs["near"])[:6]:
            links.measure(posture)
            row = links.slope(number)
            step, changes = 1e-6, []
            for joint in range(len(row)):
                for side in (1.0, -1.0):
                    links.measure(posture + side * step * np.eye(len(row))[joint])
                    changes.append(float(links.arrays.pairs["distance"][number]))
            slope = (np.array(changes[::2]) - changes[1::2]) / (2 * step)
            # Where the closest points jump from one corner to another, there is no slope.
            right.append(bool(np.abs(slope - row).max() < 1e-4))
    assert len(right) > 20
    assert np.mean(right) > 0.9


def test_shapes_cover_the_geometry_within_their_deviation(model: UrdfModel) -> None:
    for link, shapes in link_shapes(model).items():
        for shape, own in zip(shapes, model.bodies[link].collisions, strict=True):
            extent = np.ptp(shape.points, axis=0).max() + 2 * shape.radius
            diagonal = {"ball": 2, "box": 1, "cylinder": 2}[own.kind] * np.linalg.norm(own.size)
            assert extent <= diagonal + 2 * shape.deviation
            assert shape.deviation <= 0.04 * max(own.size)


def test_links_that_touch_are_nearer_than_any_clearance(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    links, contacts = LinkClearance(dexter, model, LEAST), SelfContacts(model)
    known, seen = {frozenset(names) for names in links.names}, 0
    for posture in moved(links, 600)[::30]:
        near = {frozenset((each.first, each.second)) for each in links.nearer(posture)}
        joints = links.joints
        positions = dict(zip(joints.all, joints.expand(posture).tolist(), strict=True))
        touching = set(map(frozenset, contacts.touching(positions))) & known
        seen += len(touching)
        assert touching <= near
    assert seen > 0


def test_start_posture_of_a_shipped_robot_keeps_two_centimetres(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    assert too_near_at_start(dexter, model, 0.02) == ""


def test_start_posture_nearer_than_the_clearance_names_the_links(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    told = too_near_at_start(dexter, model, 0.3)
    assert "cm from" in told and "the least is 30 cm" in told


def test_stated_shapes_replace_those_of_the_model(dexter: RobotDocument, model: UrdfModel) -> None:
    ball = HullSection(points=((0.0, 0.0, 0.0),), radius=1.0)
    stated = ClearanceSection(shapes={"left_palm": (ball,), "right_palm": ()})
    robot = dexter.model_copy(update={"clearance": stated})
    links = LinkClearance(robot, model, LEAST)
    near = {each.first for each in links.nearer(links.start)} | {
        each.second for each in links.nearer(links.start)
    }
    assert "left_palm" in near
    assert "right_palm" not in {name for pair in links.names for name in pair}


def test_clearance_without_pairs_of_links_is_a_finding(
    dexter: RobotDocument, model: UrdfModel
) -> None:
    bare = dict.fromkeys(model.bodies, ())
    robot = dexter.model_copy(update={"clearance": ClearanceSection(shapes=bare)})
    assert "no two links" in too_near_at_start(robot, model, LEAST)


@pytest.mark.parametrize("name", ["right_palm", "torso", "left_camera"])
def test_place_named_like_a_link_is_a_place_of_the_world(
    dexter: RobotDocument, model: UrdfModel, name: str
) -> None:
    ball = HullSection(points=((0.5, -0.3, 0.1),), radius=0.05)
    first, links = (
        LinkClearance(with_places(dexter, {place: ball}), model, LEAST, NEAR)
        for place in ("ball", name)
    )
    assert any("ball" in pair for pair in first.names)
    for posture in moved(first, 120)[::40]:
        first.measure(posture)
        links.measure(posture)
        pairs, same = links.arrays.pairs, first.arrays.pairs
        for key in ("first", "second", "near", "distance"):
            np.testing.assert_array_equal(pairs[key], same[key])


def test_shape_of_fine_mesh_covers_its_corners_with_few(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    ways = rng.normal(size=(300, 3))
    corners = 0.1 * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    text = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners]
    text += [f"f {k + 1} {k + 2} {k + 3}" for k in range(len(corners) - 2)]
    (tmp_path / "ball.obj").write_text("\n".join(text))
    file = tmp_path / "arm.urdf"
    file.write_text(
        '<robot name="arm"><link name="base"><collision><geometry><mesh filename="ball.obj"/>'
        "</geometry></collision></link></robot>"
    )
    (shape,) = link_shapes(read_urdf(file))["base"]
    assert 4 <= len(shape.points) <= 32
    assert 0.0 < shape.radius == shape.deviation < 0.05
    # The hull of the kept corners, grown by the radius, has a support no smaller than the mesh's.
    for way in ways / np.linalg.norm(ways, axis=1, keepdims=True):
        assert (shape.points @ way).max() + shape.radius >= (corners @ way).max() - 1e-5
