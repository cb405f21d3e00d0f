"""Meshes of stages: contacts with them, and their images."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.staging.appearance import parts_of
from cbdsl.backends.staging.scenario import SceneObject
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.convex import Convex, gap
from cbdsl.runtime.recording import drawn
from cbdsl.sensing.channels import ChannelFilter
from cbdsl.yaml_text.library import Library
from tests.backends.conftest import Simulated, run

_TOP = -0.42
# Cross-sections by corners and the quadrilaterals that they are made of, cm: a gutter, a wedge that
# falls off towards +x, and a plain box.
_GUTTER = (
    ((-6, -4), (6, -4), (6, 4), (4, 4), (4, -2), (-4, -2), (-4, 4), (-6, 4)),
    ((0, 1, 4, 5), (1, 2, 3, 4), (0, 5, 6, 7)),
)
_WEDGE = (((-5, -3), (5, -3), (-5, 3)), ((0, 1, 2),))
_BOX = (((-5, -3), (5, -3), (5, 3), (-5, 3)), ((0, 1, 2, 3),))
MESHES = {"gutter": _GUTTER, "wedge": _WEDGE, "box": _BOX}


def write_mesh(folder: Path, name: str) -> None:
    """Write an OBJ, mm, with a cross-section that extends 10 cm along y."""
    corners, parts = MESHES[name]
    count = len(corners)
    lines = [f"v {10 * x} {y} {10 * z}" for y in (-50, 50) for x, z in corners]
    faces: list[Sequence[int]] = []
    for part in parts:
        faces += [part, [count + each for each in reversed(part)]]
    for one in range(count):
        other = (one + 1) % count
        faces.append([other, one, count + one, count + other])
    lines += ["f " + " ".join(str(each + 1) for each in face) for face in faces]
    (folder / f"{name}.obj").write_text("\n".join(lines), encoding="utf-8")


def stage_with(folder: Path, mesh: str, solid: str, ball: Sequence[float] = ()) -> StageDocument:
    """Return a stage with a mesh on a table, and a ball that is released above it."""
    write_mesh(folder, mesh)
    x, y, z = ball or (0.0, 0.0, 0.0)
    place = f"\n      ball: {{things: [ball], place: {{x: {x}, y: {y}, z: {z}}}}}" if ball else ""
    thing = "\n  ball: {form: {shape: ball, radius: 2 cm}, mass: 100 g}" if ball else ""
    (folder / "made.yaml").write_text(
        f"""cbdsl: 1
kind: stage
name: made
robot: dexter
fixtures:
  table: {{form: {{shape: box, size: [60 cm, 120 cm, 4 cm]}}, position: [60 cm, 0 cm, -44 cm]}}
things:
  solid:
    form: {{shape: mesh, file: {mesh}.obj, scale: 1 mm, solid: {solid}}}
    mass: 2 kg
    color: [0, 0.4, 1]{thing}
contexts:
  always:
    placed:
      solid: {{things: [solid], place: {{on: table, x: 60 cm, y: -10 cm}}}}{place}
    joints: {{pan: -0.15, tilt: 1.15}}
""",
        encoding="utf-8",
    )
    return Library(folder).read(folder / "made.yaml", StageDocument).document


@pytest.mark.parametrize("solid", ["hull", "boxes", "box"])
@pytest.mark.parametrize("mesh", MESHES)
def test_mesh_rests_at_its_place(
    unseeing: Simulated, tmp_path: Path, mesh: str, solid: str
) -> None:
    unseeing.reset(stage_with(tmp_path, mesh, solid), None, np.random.default_rng(0))
    run(unseeing, 1.0)
    pose, height = unseeing.truth.pose("solid"), 0.04 if mesh == "gutter" else 0.03
    assert pose.position == pytest.approx([0.6, -0.1, _TOP + height], abs=3e-3)
    assert pose.rotation == pytest.approx(np.eye(3), abs=0.02)


@pytest.mark.parametrize("solid", ["hull", "boxes"])
def test_ball_falls_into_boxes_and_not_into_a_hull(
    unseeing: Simulated, tmp_path: Path, solid: str
) -> None:
    stage = stage_with(tmp_path, "gutter", solid, (0.6, -0.1, -0.3))
    unseeing.reset(stage, None, np.random.default_rng(0))
    run(unseeing, 1.0)
    inside = unseeing.truth.pose("ball").position[2] < _TOP + 0.06
    if unseeing.truth.__class__.__name__ == "KinematicEngine":
        assert solid == "hull" or inside
    else:
        assert inside == (solid == "boxes")


def test_ball_rolls_down_a_hull(unseeing: Simulated, tmp_path: Path) -> None:
    stage = stage_with(tmp_path, "wedge", "hull", (0.59, -0.1, -0.33))
    if unseeing.truth.__class__.__name__ == "KinematicEngine":
        pytest.skip("its hulls are boxes, of which nothing rolls")
    unseeing.reset(stage, None, np.random.default_rng(0))
    run(unseeing, 1.0)
    assert unseeing.truth.pose("ball").position[0] > 0.66


def test_mesh_is_drawn_in_its_own_shape(
    rendered: BulletBackend, dexter: RobotDocument, tmp_path: Path
) -> None:
    """Show a box mesh as a box for every kind of solid, and a wedge mesh as less."""
    if rendered.renderer.startswith("mujoco"):
        with pytest.raises(BackendError, match="draws no mesh"):
            rendered.reset(stage_with(tmp_path, "box", "hull"), None, np.random.default_rng(0))
        return
    hue = "hue_7"
    channels = ChannelFilter(dexter.vision.channels, [hue], least_area=4)

    def areas(mesh: str, solid: str) -> list[int]:
        rendered.reset(stage_with(tmp_path, mesh, solid), None, np.random.default_rng(0))
        seen = rendered.observe().images
        return [channels.regions(image)[hue][0].area for image in seen.values()]

    box = areas("box", "boxes")
    assert areas("box", "hull") == pytest.approx(box, rel=0.02)
    wedge = areas("wedge", "hull")
    assert all(less < 0.9 * whole for less, whole in zip(wedge, box, strict=True))


def test_hull_occupies_its_own_volume(tmp_path: Path) -> None:
    write_mesh(tmp_path, "wedge")
    wedge = SolidShape.meshed(tmp_path / "wedge.obj", 0.001, "hull")
    (body,) = wedge.bodies(Pose(np.zeros(3), np.eye(3)))

    def ball(x: float, z: float) -> Convex:
        return Convex("ball", (0.01,) * 3, np.array([x, 0.0, z]), np.eye(3))

    # The slope goes through the middle; of the box around it, this corner is free.
    across = (0.04 * 0.03 + 0.02 * 0.05) / np.hypot(0.03, 0.05)
    assert gap(body, ball(0.04, 0.02)) == pytest.approx(across - 0.01, abs=1e-6)
    assert gap(body, ball(-0.03, -0.01)) == 0.0
    assert gap(body.shrunk(1e-3), ball(0.04, 0.02)) > gap(body, ball(0.04, 0.02))


def test_recorded_mesh_can_be_drawn(tmp_path: Path) -> None:
    stage = stage_with(tmp_path, "gutter", "boxes")
    thing, rng = stage.things["solid"], np.random.default_rng(0)
    shape = SolidShape.draw(thing.form, rng)
    item = SceneObject("solid", shape, thing, 1.0, Pose(np.zeros(3), np.eye(3)))
    (part,) = (json.loads(json.dumps(drawn(part))) for part in parts_of(item))
    corners = np.array(part["mesh"]["corners"])
    assert part["shape"] == "mesh"
    assert np.ptp(corners, axis=0) == pytest.approx([0.12, 0.1, 0.08], abs=1e-5)
    assert np.max(part["mesh"]["triangles"]) == len(corners) - 1
