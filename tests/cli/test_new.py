"""``cb new``: its documents have no diagnostics, and existing files are never overwritten."""

from __future__ import annotations

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import NoReturn

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.documents.form import BoxForm
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.ready_posture import ReadyPosture
from cbdsl.robot.link_place import at_first, link_frame
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.yaml_text.library import Library, shipped
from tests.cli.test_main import cb
from tests.robot.test_chains import MODELS
from tests.robots.small_robot import LIMIT, Hinge, chain


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


# A cube that turns in place has no object within its reach, which is a warning.
REACHING = [model for model in MODELS if model.stem != "cube_rotate"]


@pytest.mark.parametrize("model", REACHING, ids=lambda path: path.stem)
def test_robots_of_any_model_and_their_programs_and_stages_are_clean(
    model: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "new", "robot", "fresh", "--urdf", str(model)) == 0
    assert cb(monkeypatch, "new", "stage", "desk", "--robot", "fresh") == 0
    assert cb(monkeypatch, "new", "program", "move", "--robot", "fresh") == 0
    session = Session(Library(folder))
    # Some of the models come without all of their meshes, which is a diagnostic.
    assert {
        each.code
        for path in folder.rglob("*.yaml")
        for each in check_document(path, session=session)
    } <= {"CB741", "CB742", "CB743", "CB744", "CB746", "CB747"}
    program = check_program(folder / "programs" / "move.yaml", {}, Library(folder))
    assert (program.robot, program.stage) == ("fresh", "desk")


@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_new_robot_mentions_every_joint_of_the_model(
    model: Path, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "new", "robot", "fresh", "--urdf", str(model)) == 0
    robot = Library(folder).read(folder / "robots" / "fresh.yaml", RobotDocument).document
    named = {joint for effector in robot.effectors.values() for joint in effector.joints}
    others = set(read_urdf(model).joints) - named - set(robot.couplings)
    text = (folder / "robots" / "fresh.yaml").read_text("utf-8")
    comments = " ".join(re.findall(r"^# [- ](.*)$", text, re.MULTILINE))
    assert all(re.search(rf" {re.escape(joint)}[,:]", f" {comments}") for joint in others)
    counts = re.findall(r"(\d+) (?:fixed|revolute|prismatic)", capsys.readouterr().err)
    assert sum(map(int, counts)) == len(others)


def test_new_robot_without_movable_joints_lists_the_joints(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = folder / "cart.urdf"
    wheel = '<joint name="wheel" type="floating"><parent link="a"/><child link="b"/></joint>'
    model.write_text(f'<robot name="cart"><link name="a"/><link name="b"/>{wheel}</robot>')
    assert cb(monkeypatch, "new", "robot", "cart", "--urdf", str(model)) == 2
    said = capsys.readouterr().err
    assert "1 is floating" in said


def test_model_is_found_and_postures_are_within_its_limits(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    joint = '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/>{}</joint>'
    limit = '<limit lower="{}" upper="3" effort="1" velocity="1"/>'
    limits = limit.format(1), limit.format(-1)
    model = folder / "two words.urdf"
    model.write_text(
        f'<robot name="m"><link name="a"/><link name="b"/><link name="c"/>'
        f"{joint.format('0', 'a', 'b', limits[0])}{joint.format('no', 'b', 'c', limits[1])}</robot>"
    )
    there = folder / "deep" / "down"
    assert cb(monkeypatch, "new", "robot", "r", "--urdf", str(model), "--to", str(there)) == 0
    robot = Library(folder).read(there / "r.yaml", RobotDocument).document
    assert (there / robot.model).resolve() == model.resolve()
    (effector,) = robot.effectors.values()
    assert effector.joints == ("0", "no")
    assert effector.postures["ready"] == pytest.approx((2.0, 0.0), abs=0.01)


def test_similar_limbs_become_a_group(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    a1 = next(path for path in MODELS if path.name == "a1.urdf")
    assert cb(monkeypatch, "new", "robot", "dog", "--urdf", str(a1)) == 0
    dog = Library(folder).read(folder / "robots" / "dog.yaml", RobotDocument).document
    assert {name: set(of.members) for name, of in dog.groups.items()} == {
        "limbs": {"FR", "FL", "RR", "RL"}
    }
    two = next(path for path in MODELS if path.name == "dexter.urdf")
    assert cb(monkeypatch, "new", "robot", "two", "--urdf", str(two)) == 0
    both = Library(folder).read(folder / "robots" / "two.yaml", RobotDocument).document
    assert both.groups["arms"].members == ("left_arm", "right_arm")


def test_new_program_moves_an_effector_away_from_its_start(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    iiwa = next(path for path in MODELS if str(path).endswith("kuka_iiwa/model.urdf"))
    assert cb(monkeypatch, "new", "robot", "kuka", "--urdf", str(iiwa)) == 0
    assert cb(monkeypatch, "new", "program", "move", "--robot", "kuka") == 0
    arm = Library(folder).read(folder / "robots" / "kuka.yaml", RobotDocument).document
    start = arm.effectors["arm"].postures[arm.effectors["arm"].start or ""]
    assert math.degrees(abs(start[3])) > 30
    assert "arm.zero" in (folder / "programs" / "move.yaml").read_text("utf-8")


@pytest.mark.parametrize("model", [m for m in MODELS if m.stem in ("a1", "xarm6_robot", "desk")])
def test_things_of_a_new_stage_are_within_a_limbs_reach(
    model: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "new", "robot", "fresh", "--urdf", str(model)) == 0
    assert cb(monkeypatch, "new", "stage", "desk", "--robot", "fresh") == 0
    robot = Library(folder).read(folder / "robots" / "fresh.yaml", RobotDocument).document
    stage = Library(folder).read(folder / "programs/stages/desk.yaml", StageDocument).document
    limb = max(robot.effectors.values(), key=lambda each: len(each.joints))
    assert limb.tip is not None
    urdf = read_urdf(model)
    joints = [urdf.joints[name] for name in limb.joints]
    length = ReadyPosture(urdf, joints, limb.tip.link, limb.tip.offset).length
    positions = {joint.name: at_first(joint) for joint in urdf.way(limb.tip.link) if joint.movable}
    shoulder = link_frame(urdf, positions, joints[0].child)[1]
    table = stage.fixtures["table"]
    assert isinstance(table.form, BoxForm) and length < 1.5
    middle = [max(each) for each in table.position]
    assert 0.3 * length < math.dist(shoulder, middle) < 1.2 * length


def test_model_without_a_name_gets_the_robots(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    desk = next(path for path in MODELS if path.name == "desk.urdf")
    model = folder / "nameless.urdf"
    model.write_text(re.sub("<robot [^>]*>", "<robot>", desk.read_text("utf-8"), count=1))
    assert cb(monkeypatch, "new", "robot", "fresh", "--urdf", str(model)) == 0
    assert "robots/fresh.urdf" in capsys.readouterr().out
    assert set(read_urdf(folder / "robots" / "fresh.urdf").joints) == set(read_urdf(desk).joints)


def test_links_that_touch_nothing_are_reported(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    desk = next(path for path in MODELS if path.name == "desk.urdf")
    assert cb(monkeypatch, "new", "robot", "whole", "--urdf", str(desk)) == 0
    assert "<collision>" not in capsys.readouterr().out
    model = folder / "ghost.urdf"
    text = desk.read_text("utf-8")
    model.write_text(re.sub("<collision>.*?</collision>", "", text, flags=re.DOTALL))
    assert cb(monkeypatch, "new", "robot", "ghost", "--urdf", str(model)) == 0
    told = "".join(capsys.readouterr())
    assert told.count("links of ghost.urdf without <collision> touch nothing: ") == 1
    assert cb(monkeypatch, "new", "stage", "room", "--robot", "ghost") == 0
    assert "touch nothing" not in "".join(capsys.readouterr())


def test_margin_of_a_narrow_joint_leaves_a_part_of_its_range(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = folder / "spring.urdf"
    model.write_text(
        '<robot name="m"><link name="a"/><link name="b"/><joint name="j" type="prismatic">'
        '<parent link="a"/><child link="b"/>'
        '<limit lower="-0.005" upper="0.005" effort="1" velocity="1"/></joint></robot>'
    )
    assert cb(monkeypatch, "new", "robot", "spring", "--urdf", str(model)) == 0


def test_first_line_names_a_schema_that_is_there(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for kind in ("program", "stage"):
        assert cb(monkeypatch, "new", kind, "fresh") == 0
    assert cb(monkeypatch, "schema", "--write", str(folder / "schemas")) == 0
    assert cb(monkeypatch, "new", "program", "later") == 0
    for path in folder.rglob("*.yaml"):
        first = path.read_text("utf-8").splitlines()[0]
        assert (path.parent / first.partition("$schema=")[2]).is_file(), first
    later = (folder / "programs" / "later.yaml").read_text("utf-8")
    assert "$schema=../schemas/program.schema.json\n" in later


def test_new_keeps_an_existing_file_without_force(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "programs" / "mine.yaml"
    path.parent.mkdir()
    path.write_text("precious", "utf-8")
    assert cb(monkeypatch, "new", "program", "mine") == 2
    assert "--force" in capsys.readouterr().err and path.read_text("utf-8") == "precious"
    assert cb(monkeypatch, "new", "program", "mine", "--force") == 0
    assert check_document(path) == []


NAMELESS = (
    '<robot><link name="a"/><link name="b"/><joint name="{joint}" type="revolute">'
    '<parent link="a"/><child link="b"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)


def test_renewed_robot_keeps_its_document_and_is_checked_against_the_model(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model, words = folder / "from.urdf", ["new", "robot", "hinge", "--urdf", "from.urdf"]
    model.write_text(NAMELESS.format(joint="turn"))
    assert cb(monkeypatch, *words, "--renew") == 2
    assert "hinge.yaml is not there" in capsys.readouterr().err
    assert cb(monkeypatch, *words) == 0
    document, urdf = folder / "robots" / "hinge.yaml", folder / "robots" / "hinge.urdf"
    mine = document.read_text("utf-8").replace("rate: 60 Hz", "rate: 120 Hz  # mine")
    document.write_text(mine, "utf-8")
    model.write_text(NAMELESS.format(joint="turn").replace('upper="1"', 'upper="1.5"'))
    assert cb(monkeypatch, *words, "--renew") == 0
    assert document.read_text("utf-8") == mine and 'upper="1.5"' in urdf.read_text("utf-8")
    model.write_text(NAMELESS.format(joint="swing"))
    capsys.readouterr()
    assert cb(monkeypatch, *words, "--renew") == 1
    assert "'turn'" in capsys.readouterr().out and document.read_text("utf-8") == mine


def test_renewed_robot_of_a_model_in_its_place_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = NAMELESS.format(joint="turn").replace("<robot>", '<robot name="m">')
    (folder / "from.urdf").write_text(text)
    words = ["new", "robot", "hinge", "--urdf", "from.urdf"]
    assert cb(monkeypatch, *words) == 0
    assert cb(monkeypatch, *words, "--renew") == 2
    assert "nothing to renew" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ("program", "no-name"),
        ("program", "p", "--robot", "dextr"),
        ("robot", "r", "--urdf", "nowhere.urdf"),
        ("robot", "r"),
        ("stage", "s", "--to", "file/below"),
    ],
)
def test_wrong_calls_write_nothing_and_exit_with_2(
    arguments: tuple[str, ...],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (folder / "file").touch()
    assert cb(monkeypatch, "new", *arguments) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert list(folder.rglob("*.yaml")) == []


@pytest.mark.parametrize(
    ("context", "outcome"), [("on_table", "Rewarded"), ("empty", "Not rewarded")]
)
def test_searchtrack_on_a_new_stage_ends_as_its_context_implies(
    context: str,
    outcome: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "new", "stage", "bench", "--robot", "dexter") == 0
    where = ("--stage", "bench", "--context", context, "--backend", "kinematic")
    assert cb(monkeypatch, "run", "searchtrack", *where) == 0
    assert f" {outcome} after" in capsys.readouterr().out


@pytest.mark.parametrize("schemas", [False, True])
def test_new_documents_name_no_file_outside_of_their_project(
    schemas: bool, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if schemas:
        cb(monkeypatch, "schema", "--write", "schemas")
    model = folder / "arm.urdf"
    model.write_bytes((shipped() / "robots" / "sixaxis.urdf").read_bytes())
    assert cb(monkeypatch, "new", "robot", "fresh", "--urdf", str(model)) == 0
    assert cb(monkeypatch, "new", "stage", "desk", "--robot", "fresh") == 0
    assert cb(monkeypatch, "new", "program", "move", "--robot", "fresh") == 0
    for path in folder.rglob("*.yaml"):
        text = path.read_text("utf-8")
        first = text.splitlines()[0]
        named = re.findall(r"(?:\.\./|docs/)[\w./-]+", text)
        assert all((path.parent / file).resolve().is_relative_to(folder) for file in named)
        assert all((path.parent / file).is_file() for file in named)
        up = "/".join(".." for _ in path.parent.relative_to(folder).parts)
        assert first.startswith(f"# yaml-language-server: $schema={up}/schemas/")


@pytest.mark.parametrize(
    ("mimic", "coupling"),
    [
        ('joint="j1" multiplier="-2" offset="0.3"', "{follows: j1, ratio: -2, offset: 0.3}"),
        ('joint="j2" multiplier="0.5" offset="-0.1"', "{follows: j1, ratio: 0.5, offset: -0.1}"),
        ('joint="nowhere"', None),
    ],
)
def test_new_robot_with_mimics_writes_couplings_that_validate(
    mimic: str, coupling: str | None, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    follower = Hinge("revolute", LIMIT + '<mimic joint="j1"/>')
    text = chain(Hinge(), follower, Hinge("revolute", f"{LIMIT}<mimic {mimic}/>"))
    (folder / "m.urdf").write_text(text)
    assert cb(monkeypatch, "new", "robot", "m", "--urdf", "m.urdf") == 0
    written = (folder / "robots" / "m.yaml").read_text("utf-8")
    if coupling is None:
        assert "couplings that it follows" not in written and "mend its <mimic>" in written
    else:
        assert f"  j3: {coupling}\n" in written
    assert cb(monkeypatch, "validate", "--strict", ".") == 0


def test_new_stage_of_a_scene_without_its_package_names_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def converted(*_: object) -> NoReturn:
        raise ModuleNotFoundError(name="mujoco")

    scenes = SimpleNamespace(get=lambda _: SimpleNamespace(converted=converted))
    monkeypatch.setattr("cbdsl.scaffold.model_format.SCENE_FORMATS", scenes)
    assert cb(monkeypatch, "new", "stage", "room", "--mjcf", "room.xml") == 2
    assert "mujoco is not installed: pip install 'cbdsl[formats]'" in capsys.readouterr().err
