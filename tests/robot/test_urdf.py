"""The structure of URDF models."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cbdsl.robot.urdf import UrdfError, read_urdf
from cbdsl.yaml_text.library import shipped

LINKS = '<robot><link name="b"/><link name="c"/>'
JOINT = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>{}</joint>'


def write(folder: Path, *parts: str) -> Path:
    path = folder / "model.urdf"
    path.write_text(f"<robot name='m'>{''.join(parts)}</robot>", encoding="utf-8")
    return path


def test_joints_and_limits(tmp_path: Path) -> None:
    model = read_urdf(
        write(
            tmp_path,
            '<link name="a"/><link name="b"/><link name="c"/><link name="d"/>',
            JOINT.format("one", "revolute", "a", "b", '<limit lower="-1" upper="2"/>'),
            JOINT.format("two", "fixed", "b", "c", ""),
            JOINT.format("three", "continuous", "c", "d", '<limit effort="1"/>'),
        )
    )
    assert model.links == {"a", "b", "c", "d"}
    assert model.revolute == ("one",)
    assert (model.joints["one"].lower, model.joints["one"].upper) == (-1, 2)
    assert (model.joints["three"].lower, model.joints["three"].upper) == (-math.inf, math.inf)
    assert list(model.above("d")) == ["one"]
    assert list(model.above("a")) == []


def test_a_loop_of_links_ends(tmp_path: Path) -> None:
    model = read_urdf(
        write(
            tmp_path,
            '<link name="a"/><link name="b"/>',
            JOINT.format("one", "revolute", "a", "b", "<limit/>"),
            JOINT.format("two", "revolute", "b", "a", "<limit/>"),
        )
    )
    assert set(model.above("a")) == {"one", "two"}


def test_the_shipped_model() -> None:
    model = read_urdf(shipped() / "robots" / "dexter.urdf")
    assert list(model.above("left_camera")) == ["tilt", "pan"]
    assert len(list(model.above("right_palm"))) == 7


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no xml",
        "<model/>",
        "<robot><joint name='a' type='fixed'/></robot>",
        LINKS + JOINT.format("a", "revolute", "b", "c", "<limit lower='x'/>") + "</robot>",
        LINKS + JOINT.format("a", "revolute", "b", "c", "") + "</robot>",
        LINKS + JOINT.format("a", "fixed", "b", "d", "") + "</robot>",
    ],
)
def test_what_is_no_model_says_so(text: str, tmp_path: Path) -> None:
    path = tmp_path / "model.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UrdfError, match=r"model\.urdf"):
        read_urdf(path)


def test_a_missing_model_says_so(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="No such file"):
        read_urdf(tmp_path / "none.urdf")
