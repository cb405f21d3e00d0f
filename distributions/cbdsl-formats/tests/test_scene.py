"""Scenes in MJCF as stages: solids at the same places, and other parts named with the reason."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from cbdsl.documents.stage import StageDocument
from cbdsl.extend.model import ConvertedModel
from cbdsl.robot.meshes.thing_mesh import read_thing_mesh
from cbdsl.robot.urdf import UrdfError
from cbdsl.yaml_text.library import Library
from cbdsl_formats.mjcf.scene import convert_scene
from tests.cli.test_main import cb

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
SEED = 5_260_000
SCENE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="table" pos="0.6 0 0.2"><geom type="box" size="0.3 0.5 0.2" euler="0 0 90"/></body>
    <body name="cube" pos="0.6 0.1 0.43" euler="0 0 20">
      <freejoint name="loose"/><geom type="box" size="0.03 0.02 0.03" rgba="1 0 0 1" mass="0.1"/>
    </body>
    <body name="egg" pos="0.4 0.4 0.5">
      <freejoint/><geom type="ellipsoid" size="0.02 0.02 0.03"/>
    </body>
    <body name="door" pos="1 1 0.5">
      <geom type="box" size="0.02 0.02 0.5" pos="-0.3 0 0"/>
      <body name="leaf">
        <joint name="hinge" axis="0 0 1"/><geom type="box" size="0.3 0.02 0.4"/>
      </body>
    </body>
    <body name="arm" pos="-1 0 0">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body><joint name="shoulder"/><geom type="sphere" size="0.05" pos="0 0 0.3"/></body>
    </body>
    <body name="sled" pos="0.2 0 0.5">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 0 1"/>
      <geom type="sphere" size="0.03" mass="0.2"/>
    </body>
  </worldbody>
  <actuator><motor joint="shoulder"/></actuator>
  KEYS
</mujoco>
"""


def converted(folder: Path, text: str) -> tuple[StageDocument, ConvertedModel]:
    """Return the stage of a scene, and the conversion, whose meshes are written."""
    path = folder / "scene.xml"
    path.write_text(text, "utf-8")
    return stage_of(path, folder)


def stage_of(path: Path, folder: Path) -> tuple[StageDocument, ConvertedModel]:
    scene = convert_scene(path, "made")
    head = "cbdsl: 1\nkind: stage\nname: made\nrobot: any\n"
    for file, contents in scene.meshes.items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_bytes(contents)
    (folder / "made.yaml").write_text(head + scene.text, "utf-8")
    return Library(folder).read(folder / "made.yaml", StageDocument).document, scene


def box_around(form: Any, position: Any, yaw: float = 0.0) -> np.ndarray:
    """Return the corners of the box around a fixture or a thing, m, shape (2, 3)."""
    if form.shape == "mesh":
        half = np.array(read_thing_mesh(form.path, form.scale).halves)
    elif form.shape == "composed" or form.shape == "box":
        half = np.array([first for first, _ in form.size]) / 2
    else:
        radius = form.radius[0]
        half = np.array(
            [radius, radius, form.height[0] / 2 if form.shape == "cylinder" else radius]
        )
    c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
    half = np.array([c * half[0] + s * half[1], s * half[0] + c * half[1], half[2]])
    middle = np.array([first for first, _ in position])
    return np.array([middle - half, middle + half])


def test_parts_of_a_scene_become_fixtures_and_things(tmp_path: Path) -> None:
    stage, scene = converted(tmp_path, SCENE.replace("KEYS", ""))
    assert stage.fixtures.keys() == {"floor", "table", "door"}
    assert stage.things.keys() == {"cube", "sled"}
    assert stage.things["cube"].color == (1.0, 0.0, 0.0)
    assert stage.things["cube"].mass == (0.1, 0.1)
    floor = box_around(stage.fixtures["floor"].form, stage.fixtures["floor"].position)
    assert floor[1, 2] == pytest.approx(0.0)
    place = stage.contexts["scene"].placed["cube"].place
    assert place.x == (0.6, 0.6) and place.z == (0.43, 0.43)
    assert place.yaw[0] == pytest.approx(math.radians(20.0), abs=1e-3)
    for part, reason in (
        ("egg", "ellipsoid"), ("door", "no joint (hinge)"), ("arm", "no joint (shoulder)"),
    ):  # fmt: skip
        assert sum(f"'{part}'" in each and reason in each for each in scene.remarks) == 1, part
    assert all(f"# {remark}" in scene.text for remark in scene.remarks)


@pytest.mark.parametrize("name", ["true", "Null", "1e3", "../x", "a: {b}", "-", "x&#10;kind: y"])
def test_body_of_any_name_is_a_thing_of_the_stage(name: str, tmp_path: Path) -> None:
    body = f'<body name="{name}"><freejoint/><geom size="0.02"/></body>'
    stage, _ = converted(tmp_path, f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    assert len(stage.things) == 1
    assert stage.contexts["scene"].placed.keys() == stage.things.keys()


def test_keyframes_give_ranges_of_places(tmp_path: Path) -> None:
    frames = [(0.5, 0.0), (0.7, -0.2), (0.6, 0.1)]
    keys = "".join(
        f'<key qpos="{x} {y} 0.43 1 0 0 0  0.4 0.4 0.5 1 0 0 0  0  0  0 0 0 0"/>' for x, y in frames
    )
    stage, _ = converted(tmp_path, SCENE.replace("KEYS", f"<keyframe>{keys}</keyframe>"))
    place = stage.contexts["scene"].placed["cube"].place
    assert place.x == (0.5, 0.7) and place.y == (-0.2, 0.1) and place.yaw == (0.0, 0.0)


@pytest.mark.parametrize("seed", range(40))
def test_solids_are_where_mujoco_has_them(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(SEED + seed)
    kind = ("box", "cylinder", "sphere", "capsule")[seed % 4]
    size = rng.uniform(0.02, 0.2, 3)
    turns = rng.integers(0, 4, 2) * 90 if kind == "box" else np.zeros(2)
    # Yaw first, then quarter turns about the other axes; some boxes tilt at any angle.
    tilt = rng.uniform(-60, 60) if seed % 8 == 0 else float(turns[0])
    angles = f"{rng.uniform(-180, 180):.3f} {tilt:.3f} {turns[1]}"
    x, y, z = rng.uniform(-1, 1, 3)
    loose = "<freejoint/>" if seed % 3 == 0 else ""
    text = f"""<mujoco><compiler eulerseq="zyx"/><worldbody>
      <body name="it" pos="{x} {y} {z}" euler="{angles}">{loose}
      <geom type="{kind}" size="{" ".join(map(str, size))}" pos="0.1 -0.05 0.03"/></body>
      </worldbody></mujoco>"""
    stage, _ = converted(tmp_path, text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    middle, halves = model.geom_aabb[0].reshape(2, 3)
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    corners = data.geom_xpos[0] + (middle + signs * halves) @ data.geom_xmat[0].reshape(3, 3).T
    if loose:
        place = stage.contexts["scene"].placed["it"].place
        assert place.z is not None
        position, yaw = (place.x, place.y, place.z), place.yaw[0]
        made = box_around(stage.things["it"].form, position, yaw)
    else:
        made = box_around(stage.fixtures["it"].form, stage.fixtures["it"].position)
    expected = np.array([corners.min(axis=0), corners.max(axis=0)])
    if kind != "box":
        # Round solids touch the box around them in the middle of its sides, at each yaw.
        around = float(size[0])
        half = np.array([around, around, expected[1, 2] - data.geom_xpos[0][2]])
        expected = np.array([data.geom_xpos[0] - half, data.geom_xpos[0] + half])
    if kind != "box" and loose:
        made = box_around(stage.things["it"].form, position)
    assert np.allclose(made, expected, atol=2e-4)


@pytest.mark.parametrize("name", ["pusher", "hopper", "ant", "half_cheetah"])
def test_public_scene_becomes_a_valid_stage(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cb(monkeypatch, "new", "stage", name, "--mjcf", str(ASSETS / f"{name}.xml")) == 0
    assert Path("programs", "stages", f"{name}.yaml").is_file()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody/></mujoco>", "no fixture and no thing"),
        (
            "<mujoco><worldbody><body name='lid'><joint name='hinge'/><geom size='1'/></body>"
            "</worldbody></mujoco>",
            "left out what moves of 'lid': a stage has no joint",
        ),
        ("<mujoco><worldbody><geom/></worldbody></mujoco>", "cannot compile"),
        ("not XML", "cannot compile"),
    ],
)
def test_scene_without_a_stage_is_one_problem(
    text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    Path("scene.xml").write_text(text, "utf-8")
    with pytest.raises(UrdfError, match=message):
        convert_scene(Path("scene.xml"), "made")
    assert cb(monkeypatch, "new", "stage", "made", "--mjcf", "scene.xml") == 2
    assert message in capsys.readouterr().err
    assert [each.name for each in Path().iterdir()] == ["scene.xml"]
