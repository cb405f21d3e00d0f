"""Tests of programs that run on any robot with effectors for their roles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.checking.roles import bind, on_robot, without_absent
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.controller import AlongNormals, Relative
from cbdsl.program.dry_run import controllers
from cbdsl.types.unit import read_quantity
from cbdsl.yaml_text.library import Library

READY = "{potential: spring, reference: $arm.ready, feedback: $arm, effector: $arm}"
OPEN = "{potential: spring, reference: $hand.open, feedback: $hand, effector: $hand}"
BOTH = f"""\
controllers: {{ready: {READY}, open: {OPEN}}}
actions: [ready, open]
"""
ROBOTS = Library().names(RobotDocument)
# The arm on a pedestal has no cameras.
SEEING = {*ROBOTS} - {"sixaxis"}


def program(folder: Path, roles: str, rest: str, name: str = "skill") -> Path:
    """Write a program with roles."""
    path = folder / "programs" / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"cbdsl: 1\nkind: program\nname: {name}\nroles: {roles}\n{rest}", "utf-8")
    return path


@pytest.mark.parametrize("robot", ROBOTS)
def test_program_with_roles_uses_an_effector_of_each_robot(robot: str) -> None:
    checked = check_program("poise", {"robot": robot})
    document = Library().read(Path("robots", f"{robot}.yaml"), RobotDocument).document
    assert checked.robot == robot and checked.parameters["arm"] in document.effectors


def test_hand_of_a_given_arm_is_the_one_on_it(tmp_path: Path) -> None:
    path = program(tmp_path, "{arm: effector of position, hand: effector of force on arm}", BOTH)
    for arm, hand in (("left_arm", "left_hand"), ("right_arm", "right_hand")):
        checked = check_program(path, {"robot": "dexter", "arm": arm})
        assert checked.parameters["hand"] == hand
    assert check_program(path, {"robot": "dexter"}).parameters["arm"] == "right_arm"


def test_shared_controller_is_called_with_a_value_of_the_robot(tmp_path: Path) -> None:
    call = "rise($arm, $arm.gap)"
    exits = f"[{{'{call} at rest': end}}]"
    rest = f"shared: {{moving: [rise]}}\nsteps: {{up: {{do: '{call}', exits: {exits}}}}}\n"
    path = program(tmp_path, "{arm: effector of position}", rest)
    for robot, gap in (("panda", 0.02), ("dexter", 0.012)):
        (action,) = check_program(path, {"robot": robot}).actions
        assert action.composition is not None
        (controller,) = action.composition.controllers
        assert controller.name == call
        assert controller.reference == Relative(None, (0.0, 0.0, gap))


def test_other_effector_differs_from_any_first_one(tmp_path: Path) -> None:
    rest = f"controllers: {{ready: {READY}, too: {READY.replace('$arm', '$second')}}}\n"
    rest += "actions: [ready, too]\n"
    roles = "{arm: effector of position, second: arm other than arm}"
    path = program(tmp_path, roles, rest)
    for arm, second in (("left_arm", "right_arm"), ("right_arm", "left_arm")):
        checked = check_program(path, {"robot": "dexter", "arm": arm})
        assert checked.parameters["second"] == second
    with pytest.raises(DiagnosticsError, match="'arm' is in both roles"):
        check_program(path, {"robot": "desk"})


@pytest.mark.parametrize(
    ("arm", "from_arm", "side", "turn", "away"),
    [
        ("left_arm", "right_arm", "-10 cm", "69.282 deg", "-20 cm"),
        ("right_arm", "left_arm", "10 cm", "-69.282 deg", "20 cm"),
    ],
)
def test_handover_goes_from_other_arm_to_given_one(
    arm: str, from_arm: str, side: str, turn: str, away: str
) -> None:
    bound = check_program("handover", {"robot": "dexter", "arm": arm}).parameters
    assert bound["from_arm"] == from_arm
    assert [bound[each].replace("arm", "hand") for each in ("arm", "from_arm")] == [
        bound["hand"], bound["from_hand"],
    ]  # fmt: skip
    assert [bound[each] for each in ("side", "turn", "away")] == [side, turn, away]


def test_handover_needs_two_arms() -> None:
    with pytest.raises(DiagnosticsError, match="'arm' is in both roles 'arm' and 'from_arm'"):
        check_program("handover", {"robot": "panda"})


def test_broken_robot_is_a_reason_only_against_itself(tmp_path: Path) -> None:
    path = program(tmp_path, "{arm: effector of position}", BOTH.replace(OPEN, READY))
    broken = tmp_path / "robots" / "broken.yaml"
    broken.parent.mkdir()
    broken.write_text("cbdsl: 1\nkind: robot\nname: broken\nmodel: none.urdf\neffectors: {}\n")
    assert check_document(path, Session(Library(tmp_path))) == []
    with pytest.raises(DiagnosticsError) as info:
        check_program(path, {"robot": "broken"}, Library(tmp_path))
    assert {each.place.file for each in info.value.diagnostics} == {str(broken)}


@pytest.mark.parametrize(
    ("roles", "problem"),
    [
        ("{arm: effector of position other than leg}", "role 'leg' is not stated above"),
        ("{arm: effector of position on leg}", "role 'leg' is not stated above"),
        ("{arm: effector at table}", "'effector at table' is no kind of effector"),
    ],
)
def test_invalid_role_is_one_finding(roles: str, problem: str, tmp_path: Path) -> None:
    path = program(tmp_path, roles, BOTH.replace(OPEN, READY))
    (found,) = check_document(path, Session())
    assert (found.code, found.message) == ("CB413", f"invalid role 'arm': {problem}")


def test_schema_may_allocate_roles_in_any_order_of_files(tmp_path: Path) -> None:
    path = program(tmp_path, "{arm: effector of position}", BOTH.replace(OPEN, READY))
    header = f"cbdsl: 1\nname: {path.stem}\nprogram: {path.stem}\n"
    texts = {
        "policies": "kind: policy\npredicates: [ready, open]\npolicy: {XX: ready, '**': open}\n",
        "schemas": "kind: schema\npolicy: skill\nfeatures: {number: count.red}\n"
        "allocations: {left: {arm: left_arm}, right: {arm: right_arm}}\n"
        "choose: {if: number > 1, then: left, else: right}\notherwise: [left, right]\n",
    }
    for folder, text in texts.items():
        file = tmp_path / "knowledge" / folder / "skill.yaml"
        file.parent.mkdir(parents=True)
        file.write_text(header + text, "utf-8")
    alone, later = Session(Library(tmp_path)), Session(Library(tmp_path))
    assert check_document(path, later) == []
    schema = tmp_path / "knowledge" / "schemas" / "skill.yaml"
    assert check_document(schema, alone) == check_document(schema, later) == []


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"robot": "desk"}, "robot 'desk' has no effector of force for role 'hand' .it has arm."),
        ({"robot": "nobody"}, "there is no robot 'nobody' .known: .*dexter"),
        ({"robot": "dexter", "arm": "leg"}, "has no effector 'leg' for role 'arm'"),
        ({"robot": "dexter", "arm": "head"}, "'head' of robot 'dexter' has no signal of position"),
        (
            {"robot": "dexter", "arm": "left_arm", "hand": "right_hand"},
            "'right_hand' is not on 'left_arm'",
        ),
    ],
)
def test_role_that_nothing_fills_is_one_finding(
    values: dict[str, str], problem: str, tmp_path: Path
) -> None:
    path = program(tmp_path, "{arm: effector of position, hand: effector of force on arm}", BOTH)
    with pytest.raises(DiagnosticsError, match=problem) as info:
        check_program(path, values)
    assert [each.code for each in info.value.diagnostics] == ["CB414"]


def test_effectors_that_fill_a_role_equally_are_named(tmp_path: Path) -> None:
    path = program(tmp_path, "{limb: effector of position}", "controllers: {}\nactions: [x]\n")
    session = Session()
    file = session.library.find(RobotDocument, "dexter", path)
    body = session.body(file or Path(), Diagnostics())
    assert not isinstance(body, Unknown)
    loaded = session.library.read_as_written(path, ProgramDocument)
    refusal = bind(loaded, body, {})
    assert isinstance(refusal, str) and "choose limb=left_arm or limb=right_arm" in refusal


def test_used_program_has_the_robot_and_the_roles_of_its_user(tmp_path: Path) -> None:
    controllers = f"controllers: {{ready: {READY}}}\nactions: [ready]\n"
    program(tmp_path, "{arm: effector of position}", controllers, "inner")
    use = "use: {inner: {program: inner}}\nactions: [inner]\n"
    outer = program(tmp_path, "{arm: effector of position}", use, "outer")
    for robot, arm in (("dexter", "left_arm"), ("panda", "arm")):
        checked = check_program(outer, {"robot": robot, "arm": arm})
        (action,) = checked.actions
        assert action.program is not None
        assert (action.program.robot, action.program.parameters["arm"]) == (robot, arm)
    named = tmp_path / "programs" / "named.yaml"
    text = "use: {inner: {program: inner, with: {arm: left_arm}}}\nactions: [inner]\n"
    named.write_text(f"cbdsl: 1\nkind: program\nname: named\nrobot: dexter\n{text}", "utf-8")
    (action,) = check_program(named).actions
    assert action.program is not None and action.program.parameters["arm"] == "left_arm"


def test_robot_for_a_program_of_another_one_is_refused() -> None:
    with pytest.raises(UsageError, match="for robot 'dexter' alone, and not for 'panda'"):
        check_program("survey", {"robot": "panda"})


@pytest.mark.parametrize("robot", sorted(SEEING))
def test_reach_is_one_program_for_each_robot(robot: str) -> None:
    checked = check_program("reach", {"robot": robot})
    (search,) = (each.program for each in checked.actions if each.program is not None)
    (reach,) = (each.composition for each in checked.actions if each.name == "reach")
    assert reach is not None
    (standoff,) = (each.standoff for each in reach.controllers if each.standoff is not None)
    document = Library().read(Path("robots", f"{robot}.yaml"), RobotDocument).document
    stated = document.effectors[checked.parameters["arm"]].values["gap"]
    assert standoff.clearance == read_quantity(stated, ("length",))
    # Only a head looks around.
    assert search.name == ("searchtrack" if "head" in document.effectors else "see")
    assert checked.stage == ("table_right" if robot == "dexter" else "over_bench")


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ("", "states no value 'gap' of 'arm'.*it states none"),
        ("values: {gapp: 1 cm}", "'gap' of 'arm'.*did you mean 'gapp'"),
        ("values: {gap: 1 N}", "does not suit controllers.approach.standoff.clearance"),
    ],
)
def test_value_that_the_robot_lacks_is_one_finding(
    values: str, problem: str, tmp_path: Path
) -> None:
    text = Path("robots", "desk.yaml").read_text("utf-8").replace("name: desk", "name: mine")
    text = re.sub("values: .*", values, text).replace(
        "desk.urdf", str(Path("robots/desk.urdf").resolve())
    )
    robot = tmp_path / "robots" / "mine.yaml"
    robot.parent.mkdir()
    robot.write_text(text, "utf-8")
    path = tmp_path / "programs" / "reach.yaml"
    path.parent.mkdir()
    path.write_text(Path("programs", "reach.yaml").read_text("utf-8"), "utf-8")
    with pytest.raises(DiagnosticsError, match=problem) as info:
        check_program(path, {"robot": "mine"}, Library(tmp_path))
    assert [each.code for each in info.value.diagnostics] == ["CB414"]


@pytest.mark.parametrize(
    ("term", "robot", "problem"),
    [
        ("0.2 span", "panda", ""),
        ("0.2 span", "desk", "robot 'desk' does not suit the program: it states no 'span'"),
        ("3 kg", "panda", "'3 kg' is no length"),
    ],
)
def test_measure_that_the_robot_lacks_is_one_finding(
    term: str, robot: str, problem: str, tmp_path: Path
) -> None:
    reference = f"reference: [bench.x, bench.y + {term}, bench.z]"
    go = f"{{potential: spring, {reference}, feedback: $arm.position, effector: $arm.position}}"
    rest = f"controllers: {{go: {go}}}\nactions: [go]\n"
    path = program(tmp_path, "{arm: effector of position}", rest)
    if not problem:
        assert check_program(path, {"robot": robot}).robot == robot
        return
    with pytest.raises(DiagnosticsError, match=problem) as info:
        check_program(path, {"robot": robot})
    assert [each.code for each in info.value.diagnostics] == ["CB414"]


def test_eyes_need_a_pair_of_cameras_and_their_heading_a_head(tmp_path: Path) -> None:
    for kind, robots in (("stereo", SEEING), ("stereo heading", {"dexter"})):
        path = program(tmp_path, f"{{arm: effector of position, eyes: {kind}}}", BOTH)
        loaded = Session().library.read_as_written(path, ProgramDocument)
        refused = {
            name for name in ROBOTS if isinstance(on_robot(name, loaded, {}, Session()), str)
        }
        assert robots == {*ROBOTS} - refused


def test_digest_of_a_program_with_roles_is_the_same_on_each_robot() -> None:
    library = Library()
    path = library.locate(ProgramDocument, "poise")
    before = program_digest(path, library)
    for robot in ROBOTS:
        check_program(path, {"robot": robot}, library)
        assert program_digest(path, library) == before


LOOK = "{potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.red, effector: $head"
SEEN = f"""\
controllers:
  ready: {READY}
  watch: {LOOK}}}
  search: {{potential: spring, reference: $head.likely, feedback: $head, effector: $head}}
  gaze: search ◁ watch
  both: gaze ◁ ready
  here: {LOOK}, otherwise: {READY}}}
models: {{likely: searchtrack_head}}
background: gaze
actions: [both, here]
"""


@pytest.mark.parametrize(("robot", "last"), [("dexter", "cyclopean.red"), ("panda", "arm")])
def test_controller_of_an_absent_role_is_left_out_or_replaced(
    robot: str, last: str, tmp_path: Path
) -> None:
    path = program(tmp_path, "{arm: effector of position, head: stereo heading if any}", SEEN)
    checked = check_program(path, {"robot": robot})
    both, here = (each.composition for each in checked.actions)
    assert both is not None and here is not None
    parts = [each.feedback.name for each in both.controllers]
    assert parts == (["head", last, "right_arm"] if robot == "dexter" else ["arm"])
    assert (checked.background is None) == (robot == "panda")
    (other,) = here.controllers
    assert other.feedback.name == last


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("hold($arm,4 cm)<|see($head) ◁ gaze", "hold($arm, 4 cm)"),
        ("gaze\n  ◁ hold($arm)", "hold($arm)"),
        ("hold($arm) ◁ ◁ see($head)", "hold($arm) ◁ ◁ see($head)"),
    ],
)
def test_composition_loses_its_terms_of_absent_roles_unless_it_cannot_be_read(
    text: str, rest: str
) -> None:
    gaze = {"potential": "spring", "feedback": "cyclopean.red", "effector": "$head"}
    data = {"controllers": {"gaze": gaze, "both": text}, "background": text}
    left = without_absent(data, {"head"})
    assert (left["controllers"], left["background"]) == ({"both": rest}, rest)


def test_role_that_is_given_is_not_absent(tmp_path: Path) -> None:
    path = program(tmp_path, "{arm: effector of position, head: stereo heading if any}", SEEN)
    with pytest.raises(DiagnosticsError, match="no effector 'neck' for role 'head'"):
        check_program(path, {"robot": "panda", "head": "neck"})


def test_lengths_in_texts_scale_with_the_hand(tmp_path: Path) -> None:
    offset = '"here + [0 cm, 0 cm, 0.2 span]"'
    go = f"{{potential: spring, reference: {offset}, feedback: $arm.position, effector: $arm}}"
    rise = go.replace("0.2 span", "$height")
    rest = f"parameters: {{height: 2 span}}\ncontrollers: {{go: {go}, rise: {rise}}}\n"
    rest += "actions: [go, rise]\n"
    path = program(tmp_path, "{arm: effector of position, hand: effector of force on arm}", rest)
    for robot, low, high in (("panda", 0.0156, 0.156), ("dexter", 0.03, 0.3)):
        checked = check_program(path, {"robot": robot})
        for action, height in zip(checked.actions, (low, high), strict=True):
            assert action.composition is not None
            (controller,) = action.composition.controllers
            assert isinstance(controller.reference, Relative)
            assert controller.reference.offset == pytest.approx((0.0, 0.0, height))


@pytest.mark.parametrize("name", ["pick_and_place", "put_down", "take_and_put_down", "set_on"])
def test_skill_is_one_program_for_hands_and_grippers(name: str) -> None:
    """Each hand holds with its own force."""
    for robot, force in (("panda", 8.0), ("dexter", 6.0)):
        every = controllers(check_program(name, {"robot": robot}))
        (hold,) = (each for each in every if each.name == "hold")
        assert isinstance(hold.reference, AlongNormals) and hold.reference.force == force


def test_relation_of_things_is_observed_by_any_effector_before_fixed_cameras() -> None:
    checked = check_program("stack", {"robot": "panda"})
    (look,) = (each for each in controllers(checked) if each.name == "on_top")
    assert (look.feedback.name, look.effector.name) == ("stereo.red.to.blue", "arm")
