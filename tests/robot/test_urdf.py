"""The structure of URDF models."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pinocchio
import pybullet as p
import pybullet_data
import pytest

from cbdsl.robot.urdf import UrdfError, UrdfOrigin
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import shipped

LINKS = '<robot name="m"><link name="b"/><link name="c"/>'
LIMIT = '<limit {} effort="1" velocity="1"/>'
MODELS = sorted(Path(pybullet_data.getDataPath()).rglob("*.urdf"))
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
            JOINT.format("one", "revolute", "a", "b", LIMIT.format('lower="-1" upper="2"')),
            JOINT.format("two", "fixed", "b", "c", ""),
            JOINT.format("three", "continuous", "c", "d", LIMIT.format("")),
        )
    )
    assert model.links == {"a", "b", "c", "d"}
    assert model.movable == ("one", "three")
    assert (model.joints["one"].lower, model.joints["one"].upper) == (-1, 2)
    assert (model.joints["three"].lower, model.joints["three"].upper) == (-math.inf, math.inf)
    assert list(model.above("d")) == ["three", "one"]
    assert list(model.above("a")) == []


def test_prismatic_joint_is_described(tmp_path: Path) -> None:
    inside = '<origin xyz="3 0 4" rpy="0 0 1"/><axis xyz="0 1 0"/><mimic joint="b" offset="2"/>'
    limit = '<limit lower="-1" upper="2" effort="30" velocity="0"/>'
    joint = JOINT.format("one", "prismatic", "a", "b", inside + limit)
    slide = read_urdf(write(tmp_path, '<link name="a"/><link name="b"/>', joint)).joints["one"]
    assert (slide.kind, slide.axis, slide.origin) == (
        "prismatic",
        (0, 1, 0),
        UrdfOrigin((3, 0, 4), (0, 0, 1)),
    )
    assert (slide.lower, slide.upper, slide.effort, slide.velocity) == (-1, 2, 30, math.inf)
    assert slide.mimic == ("b", 1, 2) and slide.slides and slide.length == 7


def test_links_have_shapes_and_inertia(tmp_path: Path) -> None:
    paint = '<material name="red"><color rgba="1 0 0 1"/></material>'
    mesh = '<geometry><mesh filename="a.stl" scale="2 2 2"/></geometry>'
    link = f"""<link name="a">
    <visual><origin xyz="0 0 1"/>{mesh}<material name="red"/></visual>
    <collision><geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>
    <inertial><mass value="2"/><inertia ixx="1" iyy="2" izz="3"/></inertial></link>"""
    body = read_urdf(write(tmp_path, paint, link)).bodies["a"]
    (visual,), (collision,) = body.visuals, body.collisions
    assert (visual.kind, visual.file, visual.size) == ("mesh", "a.stl", (2, 2, 2))
    assert visual.origin.xyz == (0, 0, 1) and visual.color == (1, 0, 0)
    assert (collision.kind, collision.size, collision.color) == ("cylinder", (0.1, 0.5), None)
    assert body.inertial is not None
    assert (body.inertial.mass, body.inertial.inertia) == (2, (1, 2, 3, 0, 0, 0))


def test_shape_without_numbers_says_which(tmp_path: Path) -> None:
    shape = '<visual><geometry><box size="1 2"/></geometry></visual>'
    path = write(tmp_path, f'<link name="a">{shape}</link>')
    with pytest.raises(UrdfError, match=r"link 'a' has size=\"1 2\", which should be three"):
        assert read_urdf(path).bodies


@pytest.mark.parametrize("rgba", ["1.~ 0 0 1", "red", "1 0", ""])
def test_color_without_numbers_says_which(rgba: str, tmp_path: Path) -> None:
    path = write(tmp_path, f'<material name="m"><color rgba="{rgba}"/></material><link name="a"/>')
    with pytest.raises(UrdfError, match=rf"material 'm' has rgba=\"{rgba}\", which should be"):
        assert read_urdf(path).bodies


@pytest.mark.parametrize(
    ("mimics", "mimic"),
    [
        ({"b": '"a" multiplier="2" offset="0.5"', "c": '"b" multiplier="3"'}, ("a", 6.0, 1.5)),
        ({"b": '"c"', "c": '"a" multiplier="-1" offset="0.25"'}, ("a", -1.0, 0.25)),
        ({"c": '"nowhere" offset="1"'}, ("nowhere", 1.0, 1.0)),
    ],
)
def test_mimics_in_a_chain_follow_the_first(
    mimics: dict[str, str], mimic: tuple[str, float, float], tmp_path: Path
) -> None:
    assert read_urdf(mimicking(mimics, tmp_path)).joints["c"].mimic == mimic


@pytest.mark.parametrize(
    ("mimics", "problem"),
    [
        ({"b": '"b"'}, "joint 'b' mimics itself; remove a <mimic>"),
        ({"b": '"c"', "c": '"b"'}, "joint 'b' mimics itself, by way of 'c'"),
        ({"a": '"b"', "b": '"c"', "c": '"b"'}, "joint 'b' mimics itself, by way of 'c'"),
    ],
)
def test_mimics_in_a_circle_are_refused(
    mimics: dict[str, str], problem: str, tmp_path: Path
) -> None:
    with pytest.raises(UrdfError, match=problem):
        read_urdf(mimicking(mimics, tmp_path))


def mimicking(mimics: dict[str, str], folder: Path) -> Path:
    """Write a model of the joints a, b and c in a row, some of which mimic others."""
    links = "".join(f'<link name="{name}"/>' for name in "xabc")
    joints = [
        JOINT.format(
            name, "revolute", parent, name, LIMIT.format('lower="-9" upper="9"')
            + (f"<mimic joint={mimics[name]}/>" if name in mimics else ""),
        )
        for parent, name in zip("xab", "abc", strict=True)
    ]  # fmt: skip
    return write(folder, links, *joints)


@pytest.mark.parametrize("limit", ["1e308", "1e16", "1e6"])
def test_limits_beyond_reason_are_none(limit: str, tmp_path: Path) -> None:
    both = LIMIT.format(f'lower="-{limit}" upper="{limit}"')
    one = LIMIT.format(f'lower="-1" upper="{limit}"')
    model = read_urdf(
        write(
            tmp_path,
            '<link name="a"/><link name="b"/><link name="c"/>',
            JOINT.format("both", "revolute", "a", "b", both),
            JOINT.format("one", "prismatic", "b", "c", one),
        )
    )
    both_ways, one_way = model.joints["both"], model.joints["one"]
    assert both_ways.endless and (both_ways.lower, both_ways.upper) == (-math.inf, math.inf)
    assert not one_way.endless and (one_way.lower, one_way.upper) == (-1.0, math.inf)


@pytest.mark.parametrize(
    ("limits", "rest"), [((-1, 2), 0.0), ((0.6, 2), 0.6), ((-2, -0.5), -0.5), ((2, 1), 0.0)]
)
def test_rest_of_a_joint_is_nearest_to_zero(
    limits: tuple[float, float], rest: float, tmp_path: Path
) -> None:
    limit = LIMIT.format(f'lower="{limits[0]}" upper="{limits[1]}"')
    follower = LIMIT.format('lower="-1" upper="1"') + '<mimic joint="a" multiplier="-3"/>'
    joints = JOINT.format("a", "revolute", "b", "c", limit)
    joints += JOINT.format("d", "revolute", "c", "e", follower)
    model = read_urdf(write(tmp_path, '<link name="b"/><link name="c"/><link name="e"/>', joints))
    assert model.rests == {"a": rest, "d": min(max(-3 * rest, -1), 1)}


def test_shipped_model_has_the_chains_of_camera_and_palm() -> None:
    model = read_urdf(shipped() / "robots" / "dexter.urdf")
    assert list(model.above("left_camera")) == ["tilt", "pan"]
    assert len(list(model.above("right_palm"))) == 7


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no element found"),
        ("no xml", "syntax error"),
        ("<model/>", "its root is <model>"),
        ("<robot name='m' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:a/></robot>", "xacro"),
        ("<robot><link name='b'/></robot>", "<robot> has no name"),
        ("<robot name='m'/>", "no <link>"),
        ("<robot name='m'><link name='b'/><link name='b'/></robot>", "two links of the name 'b'"),
        (LINKS + "</robot>", "'b' and 'c' are not joined"),
        (
            "<robot name='m'><link name='b'><inertial><mass value='-2'/></inertial></link></robot>",
            "link 'b' has the mass -2, which is below 0",
        ),
        (LINKS + "<joint name='a' type='fixed'/></robot>", "'a' has no parent"),
        (
            LINKS
            + "<link name='d'/>"
            + JOINT.format("1", "fixed", "b", "c", "")
            + JOINT.format("2", "fixed", "b", "d", "")
            + JOINT.format("3", "fixed", "d", "c", "")
            + "</robot>",
            "its link 'c' is moved by two joints, '1' and '3'",
        ),
        (LINKS + JOINT.format("1", "fixed", "c", "c", "") + "</robot>", "links 'c' carry one"),
        (
            LINKS
            + "<link name='d'/>"
            + JOINT.format("1", "fixed", "d", "c", "")
            + JOINT.format("2", "fixed", "c", "d", "")
            + "</robot>",
            "joints go in a circle: links 'c' and 'd' carry one another",
        ),
        (LINKS + "<joint type='fixed'/></robot>", "joints has no name"),
        (LINKS + JOINT.format("a", "fixed", "b", "d", "") + "</robot>", "link 'd'"),
        (
            LINKS + JOINT.format("a", "ball", "b", "c", "") + "</robot>",
            "type 'ball', which is none",
        ),
        *(
            (LINKS + JOINT.format("a", "revolute", "b", "c", inside) + "</robot>", problem)
            for inside, problem in {
                "": "has no <limit>, such as",
                "<limit lower='-1' upper='1'/>": "without effort",
                "<limit effort='1'/>": "without velocity",
                "<limit effort='-5' velocity='1'/>": "has the effort limit -5; limits are 0",
                "<limit effort='5' velocity=' -1'/>": "has the velocity limit  -1; limits are 0",
                LIMIT.format("lower='x'"): 'lower="x", which should be a number',
                LIMIT.format("lower='inf'"): 'lower="inf", which should be a number',
                # Python reads these three, and engines do not.
                LIMIT.format("lower='-1_0'"): 'lower="-1_0", which should be a number',
                LIMIT.format("lower='-\u0661'"): 'lower="-\u0661", which should be a number',
                LIMIT.format("lower='-1\u00a0'"): 'lower="-1\u00a0", which should be a number',
                LIMIT.format("")
                + "<origin xyz='0, 0, 1'/>": 'xyz="0, 0, 1", which should be three',
                LIMIT.format("") + "<axis xyz='0 1'/>": 'xyz="0 1", which should be three',
            }.items()
        ),
        (
            LINKS
            + JOINT.format("a", "fixed", "b", "c", "")
            + JOINT.format("d", "fixed", "c", "b", "")
            + "</robot>",
            "go in a circle",
        ),
    ],
)
def test_invalid_model_is_refused_with_the_reason(text: str, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "model.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UrdfError, match=rf"model\.urdf: .*{re.escape(problem)}"):
        read_urdf(path)


def test_missing_model_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="No such file"):
        read_urdf(tmp_path / "none.urdf")


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_accepted_model_can_be_built_by_pinocchio(path: Path) -> None:
    """Accept no model in the checker that kinematics refuses."""
    try:
        read_urdf(path)
    except UrdfError:
        return
    assert pinocchio.buildModelFromUrdf(str(path)).nq >= 0


@pytest.mark.parametrize(
    ("encoding", "name", "is_read"),
    [
        ("utf-8", "poignée", True),
        ("us-ascii", "grip", True),
        ("iso-8859-1", "grip", True),
        ("iso-8859-1", "poignée", False),
        ("windows-1252", "poignée", False),
        ("utf-16", "grip", False),
    ],
)
def test_names_that_engines_read_otherwise_are_refused(
    encoding: str, name: str, is_read: bool, tmp_path: Path
) -> None:
    comment = "<!-- grip -->" if encoding == "us-ascii" else "<!-- poignée -->"
    text = f'<robot name="m">{comment}<link name="{name}"/></robot>'
    file = tmp_path / "m.urdf"
    file.write_bytes(f'<?xml version="1.0" encoding="{encoding}"?>{text}'.encode(encoding))
    if is_read:
        assert read_urdf(file).links == {name}
    else:
        with pytest.raises(UrdfError, match=f"encoded in {encoding}, and engines read UTF-8"):
            read_urdf(file)


@pytest.mark.parametrize(
    "document",
    [
        '<robot name="m" xmlns="http://www.ros.org">{}</robot>',
        '<robot name="m"><drake:joint name="x"/>{}</robot>',
        '<robot name="m" xmlns:gz="http://gz.org">{}<gz:plugin gz:a="1"/></robot>',
        '\n\n<?xml version="1.0"?><robot name="m">{}</robot>',
    ],
)
def test_namespaces_and_prefixes_are_read_as_engines_read_them(
    document: str, tmp_path: Path
) -> None:
    limit = LIMIT.format('lower="-1" upper="1" drake:acceleration="3"')
    joint = JOINT.format("j", "revolute", "a", "b", limit)
    path = tmp_path / "model.urdf"
    path.write_text(document.format(f'<link name="a"/><link name="b"/>{joint}'), encoding="utf-8")
    assert read_urdf(path).movable == ("j",)
    assert list(pinocchio.buildModelFromUrdf(str(path)).names) == ["universe", "j"]
    client = p.connect(p.DIRECT)
    body = p.loadURDF(str(path), physicsClientId=client)
    assert p.getNumJoints(body, physicsClientId=client) == 1
    p.disconnect(client)


def test_links_fixed_to_a_moving_carrier_count_as_that_carrier(tmp_path: Path) -> None:
    """Hulls of a covering beside an arm overlap its wrist; a pedestal beside its base does not."""
    names = ("base", "pedestal", "upper", "cover", "fore", "wrist", "other")
    tree = [
        ("base", "pedestal", "fixed"), ("base", "upper", "revolute"), ("upper", "cover", "fixed"),
        ("upper", "fore", "revolute"), ("fore", "wrist", "revolute"), ("base", "other", "revolute"),
    ]  # fmt: skip
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    links = [f'<link name="{name}"/>' for name in names]
    joints = [JOINT.format(f"{a}_{b}", kind, a, b, limit) for a, b, kind in tree]
    pairs = read_urdf(write(tmp_path, *links, *joints)).carried_pairs()
    beside = {("cover", "wrist"), ("cover", "fore"), ("cover", "upper")}
    carried = {tuple(sorted(pair)) for pair in (("base", n) for n in names[1:])} | {
        ("fore", "upper"), ("upper", "wrist"), ("fore", "wrist")
    }  # fmt: skip
    assert pairs == beside | carried
