"""All engines simulate the same masses."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pybullet as p
import pybullet_data
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.public_models import models
from cbdsl.backends.bullet.articulation import BulletRobot
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.link_mass import LinkMass, link_masses
from cbdsl.kinematics.pose import Pose
from cbdsl.robot.chains import root
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_mujoco.robot_spec import body_name, compile_spec, make_robot_spec

DATA = Path(pybullet_data.getDataPath())
#: Public models with frames without mass, impossible moments, and links without moments.
PUBLIC = (
    "franka_panda/panda.urdf",
    "kuka_iiwa/model.urdf",
    "laikago/laikago_toes.urdf",
    "mini_cheetah/mini_cheetah.urdf",
    "quadruped/minitaur.urdf",
    "racecar/racecar.urdf",
    "xarm/xarm6_with_gripper.urdf",
    "TwoJointRobot_w_fixedJoints.urdf",
    "r2d2.urdf",
)
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="1"/>'
NUMBERS = st.floats(-2.0, 2.0).map(lambda number: round(number, 3))
INERTIALS = st.none() | st.tuples(
    st.floats(0.0, 5.0), st.tuples(*[NUMBERS] * 6), st.tuples(*[NUMBERS] * 6)
)
Floats6 = tuple[float, ...]
Inertial = tuple[float, Floats6, Floats6] | None


def robot_of(model: UrdfModel) -> RobotDocument:
    driven = [joint.name for joint in model.joints.values() if unsupported(joint) is None]
    return RobotDocument.model_validate(
        {
            "cbdsl": 1,
            "kind": "robot",
            "name": "public",
            "model": str(model.path),
            "base": root(model),
            "effectors": {"all": {"joints": driven}},
            "control": {"rate": 60, "tasks": {}},
        }
    )


def on_bullet(model: UrdfModel) -> Iterator[tuple[str, LinkMass]]:
    client = p.connect(p.DIRECT)
    robot = BulletRobot(client, robot_of(model), model, 1 / 240)
    for link, number in robot.links.items():
        row = p.getDynamicsInfo(robot.id, number, physicsClientId=client)
        yield link, LinkMass(row[0], Pose.of(row[3], row[4]), np.array(row[2]))
    p.disconnect(client)


def on_mujoco(model: UrdfModel) -> Iterator[tuple[str, LinkMass]]:
    compiled = compile_spec(make_robot_spec(robot_of(model), model, 1 / 240), model)
    for link in model.links:
        body = compiled.body(body_name(link))
        w, x, y, z = body.iquat
        yield link, LinkMass(float(body.mass[0]), Pose.of(body.ipos, (x, y, z, w)), body.inertia)


def assert_equal(one: LinkMass, other: LinkMass, link: str) -> None:
    assert one.mass == pytest.approx(other.mass, rel=1e-6), link
    if one.mass:
        centre = pytest.approx(other.frame.position, abs=1e-6)
        assert one.frame.position == centre, link
    scale = max(float(np.abs(other.moments).max()), 1e-9)
    assert np.abs(one.inertia - other.inertia).max() < 1e-4 * scale, link


def assert_engines_agree(model: UrdfModel) -> None:
    expected = link_masses(model)
    for engine in (on_bullet, on_mujoco):
        for link, mass in engine(model):
            if link != root(model):  # the base does not move
                assert_equal(mass, expected[link], f"{engine.__name__}: {link}")


@pytest.mark.parametrize("file", PUBLIC)
def test_link_masses_of_public_models_are_equal_on_all_engines(file: str) -> None:
    assert_engines_agree(read_urdf(DATA / file))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "file"), list(models()), ids=lambda each: str(each).rpartition("/")[2]
)
def test_link_masses_of_sixty_public_models_are_equal_on_all_engines(
    name: str, file: Path | None
) -> None:
    if file is None:
        pytest.skip(f"pip install --no-deps {name.partition(':')[0]}")
    try:
        model = read_urdf(file)
    except UrdfError as error:
        pytest.skip(f"it is no URDF: {error}")
    if all(unsupported(joint) for joint in model.joints.values()):
        pytest.skip("no joint can be driven")
    assert_engines_agree(model)


def arm(folder: Path, inertials: list[Inertial]) -> UrdfModel:
    """Return a model of links in series, of which every third one is fixed."""
    parts = ['<link name="l0"/>']
    for i, inertial in enumerate(inertials, start=1):
        inside = ""
        if inertial is not None:
            mass, moments, origin = inertial
            keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            values = " ".join(f'{k}="{v}"' for k, v in zip(keys, moments, strict=True))
            xyz, rpy = (" ".join(map(str, each)) for each in (origin[:3], origin[3:]))
            inside = (
                f'<inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{mass}"/>'
                f"<inertia {values}/></inertial>"
            )
        kind = "fixed" if i % 3 == 0 else "revolute"
        parts.append(
            f'<link name="l{i}">{inside}</link><joint name="j{i}" type="{kind}"><parent '
            f'link="l{i - 1}"/><child link="l{i}"/><axis xyz="0 0 1"/>{LIMIT}</joint>'
        )
    file = folder / "arm.urdf"
    file.write_text(f'<robot name="arm">{"".join(parts)}</robot>')
    return read_urdf(file)


@settings(max_examples=60)
@given(st.lists(INERTIALS, min_size=3, max_size=5))
def test_link_masses_of_any_model_are_equal_on_all_engines(
    tmp_path_factory: pytest.TempPathFactory, inertials: list[Inertial]
) -> None:
    assert_engines_agree(arm(tmp_path_factory.mktemp("models"), inertials))


@given(st.tuples(st.floats(0.0, 5.0), st.tuples(*[NUMBERS] * 6), st.just((0.0,) * 6)))
def test_link_mass_is_that_of_a_body_and_of_the_model_if_it_is_possible(
    tmp_path_factory: pytest.TempPathFactory, inertial: tuple[float, Floats6, Floats6]
) -> None:
    model = arm(tmp_path_factory.mktemp("models"), [None, None, inertial])
    of = link_masses(model)["l3"]
    least, middle, most = sorted(of.moments.tolist())
    assert least >= 0.0
    assert most <= (least + middle) * (1 + 1e-9)
    xx, yy, zz, xy, xz, yz = inertial[1]
    given_moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    least, middle, most = np.linalg.eigvalsh(given_moments)
    if least >= 0.0 and most <= least + middle:
        assert of.inertia == pytest.approx(given_moments, abs=1e-9)
    else:
        assert np.ptp(of.moments) == 0.0


def test_link_masses_of_frames_without_mass_are_zero(tmp_path: Path) -> None:
    solid = (1.0, (0.01, 0.01, 0.01, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    model = arm(tmp_path, [solid, solid, None])
    for engine in (on_bullet, on_mujoco):
        masses = {link: of.mass for link, of in engine(model) if link != "l0"}
        assert masses == {"l1": 1.0, "l2": 1.0, "l3": 0.0}
