"""Moments of inertia and shapes that no body has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.robot.plausibility import flat_shapes, odd_inertias, odd_numbers, principal_moments
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import parse_urdf

LENGTHS = st.floats(1e-3, 3.0)
ANGLES = st.tuples(*[st.floats(-3.2, 3.2)] * 3)


def model(inside: str, joint: str = "revolute") -> UrdfModel:
    """Return a model of a link with some content that hangs on a joint."""
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    text = (
        f'<robot name="m"><link name="a"/><link name="b">{inside}</link><joint name="j" '
        f'type="{joint}"><parent link="a"/><child link="b"/>{limit}</joint></robot>'
    )
    return parse_urdf(text, Path("m.urdf"))


def inertial(mass: float, moments: np.ndarray) -> str:
    """Return an ``<inertial>`` of a symmetric matrix (3, 3), kg m^2."""
    keys = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2)}
    keys["iyz"] = (1, 2)
    values = " ".join(f'{key}="{float(moments[at])!r}"' for key, at in keys.items())
    return f'<inertial><mass value="{mass!r}"/><inertia {values}/></inertial>'


def turned(moments: np.ndarray, angles: tuple[float, float, float]) -> np.ndarray:
    """Return principal moments (3,) as a matrix in axes turned by three angles, rad."""
    rotation = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.eye(3)
        i, k = (axis + 1) % 3, (axis + 2) % 3
        turn[[i, i, k, k], [i, k, i, k]] = c, -s, s, c
        rotation = rotation @ turn
    return rotation @ np.diag(moments) @ rotation.T


@given(st.floats(1e-3, 50.0), st.tuples(LENGTHS, LENGTHS, LENGTHS), ANGLES)
def test_odd_inertias_of_a_solid_box_are_none(
    mass: float, size: tuple[float, float, float], angles: tuple[float, float, float]
) -> None:
    squares = np.array(size) ** 2
    moments = mass / 12 * (squares.sum() - squares)
    assert not [*odd_inertias(model(inertial(mass, turned(moments, angles))))]


@given(st.lists(st.floats(-10, 10), min_size=6, max_size=6))
def test_principal_moments_are_the_eigenvalues(entries: list[float]) -> None:
    xx, yy, zz, xy, xz, yz = entries
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert principal_moments(tuple(entries)) == pytest.approx(np.linalg.eigvalsh(matrix), abs=1e-6)


@pytest.mark.parametrize(
    ("mass", "moments", "reason"),
    [
        (1.0, [0.1, 0.1, 0.3], "more than the sum of the others"),
        (1.0, [0.1, 0.1, -0.1], "a principal moment of inertia of -0.1"),
        (2.0, [0.0, 0.0, 0.0], "a mass of 2 kg and no moment"),
        (1.0, [900.0, 900.0, 900.0], "a radius of gyration of 30 m"),
        (1.0, [1e308, 1e308, 1e308], "a moment of inertia beyond"),
    ],
)
@given(angles=ANGLES)
def test_odd_inertias_gives_the_reason(
    mass: float, moments: list[float], reason: str, angles: tuple[float, float, float]
) -> None:
    matrix = turned(np.array(moments), angles) if max(moments) < 1e300 else np.diag(moments)
    ((link, told),) = odd_inertias(model(inertial(mass, matrix)))
    assert link == "b" and reason in told


def test_odd_inertias_of_a_point_fixed_to_a_link_are_none() -> None:
    assert not [*odd_inertias(model(inertial(1.0, np.zeros((3, 3))), "fixed"))]


@pytest.mark.parametrize("use", ["collision", "visual"])
@pytest.mark.parametrize(
    ("shape", "told"),
    [
        ('<box size="0.1 0 0.1"/>', "a box of size 0.1 0 0.1"),
        ('<sphere radius="0"/>', "a ball of size 0"),
        ('<sphere radius="-0.1"/>', "a ball of size -0.1"),
        ('<cylinder radius="0.1" length="0"/>', "a cylinder of size 0.1 0"),
        ('<mesh filename="a.stl" scale="1 1 0"/>', "a scaled mesh of size 1 1 0"),
        ('<mesh filename="a.stl" scale="1 -1 1"/>', None),
        ('<box size="0.1 0.2 0.3"/>', None),
    ],
)
def test_flat_shapes_names_shapes_without_volume(shape: str, told: str | None, use: str) -> None:
    found = [*flat_shapes(model(f"<{use}><geometry>{shape}</geometry></{use}>"))]
    assert found == ([] if told is None else [("b", told)])


JOINT = (
    '<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><origin xyz="{origin}"/>'
    '<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" effort="1" velocity="{speed}"/>'
    "</joint>"
)
USUAL = {
    "kind": "revolute", "origin": "0 0 1", "axis": "0 0 1", "lower": "-3", "upper": "3",
    "speed": "1", "mass": "2",
}  # fmt: skip


def numbered(**numbers: str) -> list[tuple[str, str]]:
    """Return the odd numbers of a model that is usual but for the given ones."""
    parts = USUAL | numbers
    mass = f'<inertial><mass value="{parts.pop("mass")}"/></inertial>'
    text = f'<robot name="m"><link name="a"/><link name="b">{mass}</link>{JOINT}</robot>'
    return [*odd_numbers(parse_urdf(text.format(**parts), Path("m.urdf")))]


@pytest.mark.parametrize(
    ("numbers", "reason"),
    [
        ({"lower": "-180", "upper": "180"}, "limits of -180 to 180 rad, as if in degrees"),
        ({"upper": "360"}, "limits of -3 to 360 rad, as if in degrees"),
        ({"kind": "prismatic", "upper": "2000"}, "limits of -3 to 2000 m"),
        ({"origin": "1e308 1e308 0"}, "a distance of 1.41e+308 m from its parent"),
        ({"origin": "0 5000 0"}, "a distance of 5e+03 m from its parent"),
        ({"kind": "fixed", "origin": "0 5000 0"}, "a distance of 5e+03 m from its parent"),
        ({"axis": "1e200 0 0"}, "an axis of length 1e+200"),
        ({"axis": "0 0 1e-9"}, "an axis of length 1e-09"),
        ({"speed": "1e-320"}, "a range or speed below 1e-06 rad"),
        ({"lower": "0", "upper": "1e-300"}, "a range or speed below 1e-06 rad"),
    ],
)
def test_odd_numbers_of_a_joint_are_named(numbers: dict[str, str], reason: str) -> None:
    assert numbered(**numbers) == [("j", reason)]


def test_odd_numbers_of_a_heavy_link_are_named() -> None:
    assert numbered(mass="1e7") == [("b", "a mass of 1e+07 kg")]


@pytest.mark.parametrize(
    "numbers",
    [
        {},
        {"lower": "-62", "upper": "62"},
        {"lower": "-1e10", "upper": "1e10"},
        {"kind": "continuous", "lower": "-180", "upper": "180"},
        {"kind": "fixed", "axis": "0 0 0"},
        {"speed": "0"},
        {"axis": "0 3 4"},
    ],
)
def test_odd_numbers_of_a_usual_model_are_none(numbers: dict[str, str]) -> None:
    assert numbered(**numbers) == []
