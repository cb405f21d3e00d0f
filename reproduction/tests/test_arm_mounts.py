"""Mounts of Dexter's arms are written, moved, judged and searched as documented."""

from __future__ import annotations

import importlib
from dataclasses import astuple, replace
from math import radians
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from tests.conftest import ROOT

STEP = 1e-6
PLACE = (0.55, -0.2)


@pytest.fixture
def modules() -> Any:
    """Return the function that imports a module of the mounts by its name."""
    return lambda name: importlib.import_module(f"cbdsl_reproduction.mounts.{name}")


@pytest.fixture
def sideways(modules: Any) -> Any:
    """Return a mount whose joints 1 point outward and a little down, with hands before the body."""
    return modules("arm_mount").ArmMount(
        0.13, 0.13, 0.21, 0.0, radians(-23), radians(-73), radians(98), 0.19, 0.45, -0.13
    )


def _tip(kinematics: Kinematics, robot: RobotDocument, side: str) -> np.ndarray:
    tip = robot.effectors[f"{side}_arm"].tip
    assert tip is not None
    return kinematics.point(tip.link, tip.offset).position


def test_mount_of_today_equals_the_mount_of_the_model(
    modules: Any, dexter: RobotDocument, urdf: Path, tmp_path: Path
) -> None:
    file = tmp_path / "mounted.urdf"
    file.write_text(modules("arm_mount").TODAY.urdf(), encoding="utf-8")
    assert ElementTree.parse(file).getroot().get("name") == "dexter"
    ours, written = Kinematics(dexter, urdf), Kinematics(dexter, file)
    posture = np.random.default_rng(7).uniform(-1, 1, len(ours.joints))
    for each in (ours, written):
        each.update(posture)
    for side in ("left", "right"):
        assert _tip(written, dexter, side) == pytest.approx(_tip(ours, dexter, side), abs=1e-6)


def test_base_of_a_mounted_arm_has_the_stated_pose(
    modules: Any, sideways: Any, dexter: RobotDocument
) -> None:
    arms = modules("mounted_arms").MountedArms(dexter, sideways)
    base = arms.kinematics.frame("right_link_1")
    assert base.position == pytest.approx([0.13, -0.13, 0.21], abs=1e-6)
    # Outward is to the right, and the axis of a joint does not turn with it.
    axis = [0.0, -np.cos(radians(23)), -np.sin(radians(23))]
    assert base.rotation[:, 2] == pytest.approx(axis, abs=1e-6)


def test_resting_postures_of_both_arms_are_mirror_images(
    modules: Any, sideways: Any, dexter: RobotDocument
) -> None:
    arms = modules("mounted_arms").MountedArms(dexter, sideways)
    arms.rest()
    arms.kinematics.update(arms.posture)
    right, left = (_tip(arms.kinematics, dexter, side) for side in ("right", "left"))
    assert right == pytest.approx([0.19, -0.45, -0.13], abs=0.01)
    # The tip is 6 mm beside the middle of the palm, in both hands to the same side.
    assert left == pytest.approx(right * [1, -1, 1], abs=0.015)


@pytest.mark.parametrize("jacobian", ["position", "pose", "relative", "chain"])
def test_gradients_by_finite_differences(
    jacobian: str, modules: Any, dexter: RobotDocument
) -> None:
    mounted = modules("mounted_arms")
    arms = mounted.MountedArms(dexter, modules("arm_mount").TODAY)
    arms.rest()
    arms.posture += 0.05
    gradient, differences = arms.gradient(jacobian), []
    for joint in [*arms.own["left"], *arms.own["right"]]:
        measures = []
        for step in (STEP, -STEP):
            arms.posture[joint] += step
            measures.append(_measure(arms, jacobian))
            arms.posture[joint] -= step
        differences.append((measures[0] - measures[1]) / (2 * STEP))
    assert gradient == pytest.approx(np.array(differences), abs=1e-6)


def _measure(arms: Any, jacobian: str) -> float:
    """Return the logarithm of the manipulability, from its definition (Eq 3.5)."""
    arms.kinematics.update(arms.posture)
    points = {side: arms.kinematics.point(*arms.tips[side]) for side in arms.own}
    rows = {side: point.jacobian[:, arms.own[side]] for side, point in points.items()}
    if jacobian in ("position", "pose"):
        count = 3 if jacobian == "position" else 6
        return sum(_volume(own[:count]) for own in rows.values())
    left = rows["left"][:3]
    if jacobian == "chain":
        # As if the left hand were the base of one chain, and the right one its tip.
        way = points["right"].position - points["left"].position
        left = left + np.cross(rows["left"][3:].T, way).T
    return _volume(np.hstack((-left, rows["right"][:3])))


def _volume(rows: np.ndarray) -> float:
    return 0.5 * float(np.log(np.linalg.det(rows @ rows.T)))


def test_only_arms_that_turn_about_a_level_axis_bring_the_hands_together(
    modules: Any, sideways: Any, dexter: RobotDocument
) -> None:
    mounted, today = modules("mounted_arms"), modules("arm_mount").TODAY

    def meeting(mount: Any) -> Any:
        arms = mounted.MountedArms(dexter, mount)
        assert arms.reach(PLACE).arrived
        return arms.bring_together("position")

    # Manipulability does not depend on joint 1, so that the way there decides the last decimetres.
    rng = np.random.default_rng(1)
    mounts = [
        replace(
            sideways,
            lift=sideways.lift + lift,
            roll=sideways.roll + roll,
            elbow=sideways.elbow + elbow,
        )
        for lift, roll, elbow in rng.uniform(-0.1, 0.1, (6, 3))
    ]
    meetings = [meeting(mount) for mount in mounts]
    assert any(each.together for each in meetings)
    assert all(each.apart < 0.5 for each in meetings)
    # As on the engine: 1.42 to 1.66 m.
    apart = meeting(today)
    assert not apart.near and 1.4 < apart.apart < 1.8


def test_place_behind_an_arm_is_not_seen(modules: Any, dexter: RobotDocument) -> None:
    arms = modules("mounted_arms").MountedArms(dexter, modules("arm_mount").TODAY)
    arms.rest()
    place = np.array((*PLACE, -0.35))
    seen, phi = arms.sees(place, held=())
    assert seen and phi > 0
    arms.reach(PLACE)
    assert not arms.sees(place, held=())[0]
    # Above the head the cameras cannot look.
    assert np.isnan(arms.sees(np.array((0.2, 0.0, 1.5)), held=())[1])


def test_interrupted_search_of_mounts_resumes_with_the_same_result(
    modules: Any, tmp_path: Path
) -> None:
    search = modules("search_mounts")
    whole = search.search(tmp_path / "whole.jsonl", "position", 2, 3, 0, 600.0)
    search.search(tmp_path / "parts.jsonl", "position", 2, 1, 0, 600.0)
    parts = search.search(tmp_path / "parts.jsonl", "position", 2, 3, 0, 600.0)
    assert [trial.number for trial in whole] == [0, 1, 2, 3]
    assert (tmp_path / "parts.jsonl").read_text() == (tmp_path / "whole.jsonl").read_text()
    assert parts[0].reach > 0.9 and parts[0].near == 0.0
    picture = modules("mount_map").svg(parts)
    root = ElementTree.fromstring(picture)
    assert root.tag.endswith("svg") and ">today's</text>" in picture


def test_search_of_mounts_without_a_spread_begins_near_the_mount_of_today(modules: Any) -> None:
    search, mounts = modules("search_mounts"), modules("arm_mount")
    drawn = search._draw(1, [SimpleNamespace(mount={})], 0, 10, 7)
    assert isinstance(drawn, mounts.ArmMount) and drawn != mounts.TODAY
    assert np.abs(np.subtract(astuple(drawn), astuple(mounts.TODAY))).max() < 2


def test_score_prefers_near_hands_and_keeps_reach(modules: Any) -> None:
    trial = modules("mount_trial").MountTrial
    today = trial(
        0, "position", {}, [1.5] * 12, [1.5] * 12, [True] * 12, [False] * 12, (), 1.0, 1.0
    )
    near = today._replace(apart=[0.1] * 12, aims=[0.02] * 12, seen=[True] * 12)
    assert near.score(today) == pytest.approx(2.0) and near.near == near.together == 1.0
    assert today.score(today) == 0.0
    assert near._replace(reach=0.98).score(today) == pytest.approx(2.0)
    assert near._replace(reach=0.88).score(today) == pytest.approx(1.8)
    assert near._replace(possible=[False] * 12).together == 0.0


def test_posture_of_one_arm_is_rewritten(modules: Any) -> None:
    text = (ROOT / "robots" / "dexter.yaml").read_text(encoding="utf-8")
    changed = modules("mounted_touch").with_posture(text, "right_arm", "ready", [0.5] * 7)
    differing = [
        (old, new)
        for old, new in zip(text.splitlines(), changed.splitlines(), strict=True)
        if old != new
    ]
    assert len(differing) == 1
    assert differing[0][0].startswith("      ready: [0.44,")
    assert differing[0][1] == "      ready: [" + ", ".join(["0.5000"] * 7) + "]"


def test_opposed_arms_come_to_rest_with_palms_opposite_each_other(
    modules: Any, dexter: RobotDocument
) -> None:
    mount, postures = modules("mounted_touch").read_opposed()
    # The mount's own posture is not looked for: the file has it.
    arms = modules("mounted_arms").MountedArms(dexter, mount)
    for side in ("left", "right"):
        arms.posture[arms.own[side]] = postures[f"{side}_arm"]["home"]
    assert 0.15 < arms.bring_together("position").apart < 0.25
    arms.kinematics.update(arms.posture)
    normals = [arms.kinematics.frame(f"{side}_palm").rotation[:, 2] for side in ("left", "right")]
    assert np.degrees(np.arccos(normals[0] @ normals[1])) > 120


def test_mount_near_another_is_within_the_bounds(modules: Any) -> None:
    mounts = modules("arm_mount")
    rng = np.random.default_rng(3)
    low, high = mounts.BOUNDS
    for mount in [*mounts.spread_over(5, rng), mounts.near(replace(high, roll=3.1), 0.3, rng)]:
        for name in mounts.NAMES:
            assert getattr(low, name) <= getattr(mount, name) <= getattr(high, name)
