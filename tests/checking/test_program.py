"""The result of checking a program without faults."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from cbdsl.checking.program import check_program
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.program.controller import AlongNormals, Literal, Relative
from cbdsl.yaml_text.library import Library

HEAD = "cbdsl: 1\nkind: program\nname: own\nrobot: dexter\n"
LOOK = "potential: spring, reference: 0, feedback: cyclopean.$feature, effector: head"


def write(folder: Path, text: str) -> Path:
    path = folder / "programs" / "own.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(HEAD + text, encoding="utf-8")
    return path


def test_composites_are_one_primitive_with_the_last_controller_leading(tmp_path: Path) -> None:
    program = check_program("reachtouch")
    assert program.members == ("searchtrack", "reach", "touch")
    reach = program.primitives["reach"]
    assert [c.name for c in reach.controllers] == ["posture", "orient", "approach"]
    assert reach.lead.name == "approach"


def test_once_of_seek_names_a_call_as_actions_do(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "shared: {looking: [watch]}\n"
        "controllers:\n"
        "  touch: {potential: spring, reference: 1 N along normals, "
        "feedback: right_hand.finger_forces, effector: right_hand, "
        "seek: {once: 'watch( motion )'}}\n"
        "actions: [watch(motion), touch]\n",
    )
    seek = check_program(path, library=Library(tmp_path)).primitives["touch"].lead.seek
    assert seek is not None and seek.once == "watch(motion)"


def test_only_signals_of_the_environment_are_rewarded() -> None:
    search = check_program("searchtrack").primitives
    assert [name for name, primitive in search.items() if primitive.lead.rewarded] == ["track"]
    assert check_program("reachtouch").primitives["touch"].lead.rewarded


def test_parameters_reach_used_programs() -> None:
    program = check_program(
        "reachtouch", {"feature": "green", "arm": "left_arm", "hand": "left_hand"}
    )
    used = program.actions[0].program
    assert used is not None and used.parameters["feature"] == "green"
    assert used.primitives["track"].lead.feedback.name == "cyclopean.green"
    assert program.primitives["reach"].lead.joints[0] == "left_arm_1"


def test_arguments_bind_parameters(tmp_path: Path) -> None:
    text = (
        "shared: {looking: [watch]}\ncontrollers: {}\n"
        "actions: [watch(hue_1), watch(hue_2), watch(hue_1) <| watch(hue_2)]\n"
        'policy: {"**": "watch(hue_1)<|watch(hue_2)"}\n'
    )
    program = check_program(write(tmp_path, text))
    assert program.members == ("watch(hue_1)", "watch(hue_2)")
    assert program.policy == {"**": "watch(hue_1) ◁ watch(hue_2)"}
    channels = [p.lead.feedback.name for p in program.primitives.values()]
    assert channels == ["cyclopean.hue_1", "cyclopean.hue_2"]


def test_settings_come_from_the_robot_unless_the_controller_has_its_own() -> None:
    track, search = (check_program("searchtrack").primitives[n].lead for n in ("track", "search"))
    assert track.gain == 15 and search.gain == 8
    assert search.quiescence.rate == 1e-3


def test_literals_are_si_and_a_single_zero_is_spread() -> None:
    primitives = check_program("reachtouch").primitives
    orient = primitives["reach"].controllers[1]
    assert orient.reference == Literal((pytest.approx(3.14159265), 0.0, 0.0))
    assert primitives["touch"].lead.reference == AlongNormals(2.0)


def test_chains_lead_from_the_feedback_to_joints() -> None:
    for name in ("searchtrack", "reachtouch", "visualinspect"):
        for primitive in check_program(name).primitives.values():
            for controller in primitive.controllers:
                (chain,) = controller.chains
                at = controller.feedback.type.name
                for cast in chain:
                    assert cast.source == at
                    at = cast.target
                assert at == "configuration"


@pytest.mark.parametrize(
    ("effector", "casts"),
    [
        ("head", ["inverse camera Jacobian"]),
        (
            "right_arm",
            ["inverse sighting Jacobian", "rigid hold", "inverse manipulator Jacobian"],
        ),
    ],
)
def test_heading_has_the_chain_of_its_effector(
    tmp_path: Path, effector: str, casts: list[str]
) -> None:
    look = LOOK.replace("$feature", "hue_1").replace("effector: head", f"effector: {effector}")
    path = write(tmp_path, f"controllers:\n  look: {{{look}}}\nactions: [look]\n")
    (chain,) = check_program(path).primitives["look"].lead.chains
    assert [cast.name for cast in chain] == casts


def test_unknown_names_are_usage_errors() -> None:
    with pytest.raises(UsageError, match="did you mean 'searchtrack'"):
        check_program("serchtrack")
    with pytest.raises(UsageError, match="unknown parameter 'featur'; did you mean 'feature'"):
        check_program("searchtrack", {"featur": "hue_1"})


def test_wrong_value_of_a_parameter_is_a_finding() -> None:
    with pytest.raises(DiagnosticsError, match="CB501"):
        check_program("searchtrack", {"feature": "hue_99"})


def test_documents_next_to_the_program_come_before_shipped_ones(tmp_path: Path) -> None:
    text = f"parameters: {{feature: hue_1}}\ncontrollers: {{look: {{{LOOK}}}}}\nactions: [look]\n"
    path = write(tmp_path, text)
    near = path.with_name("searchtrack.yaml")
    near.write_text(path.read_text("utf-8").replace("own", "searchtrack"), encoding="utf-8")
    using = path.read_text("utf-8") + "use: {s: {program: searchtrack}}\n"
    path.write_text(using.replace("[look]", "[look, s]"), encoding="utf-8")
    program = check_program("own", library=Library(tmp_path))
    assert program.actions[1].program is not None
    assert program.actions[1].program.members == ("look",)


def test_closest_pattern_resolves_an_ambiguity(tmp_path: Path) -> None:
    text = (
        "parameters: {feature: hue_1}\n"
        f"controllers: {{look: {{{LOOK}}}, watch: {{{LOOK}}}}}\nactions: [look, watch]\n"
        'policy: {"1*": look, "*1": watch, "11": look, "**": watch}\n'
    )
    program = check_program(write(tmp_path, text))
    for state in ("".join(pair) for pair in product("X-01", repeat=2)):
        matching = [
            p for p in program.policy if all(a in ("*", b) for a, b in zip(p, state, strict=True))
        ]
        fewest = min(p.count("*") for p in matching)
        assert len({program.policy[p] for p in matching if p.count("*") == fewest}) == 1


def test_faulty_part_does_not_hide_the_others_from_its_users(tmp_path: Path) -> None:
    text = (
        "parameters: {feature: [hue_1]}\n"
        f"controllers:\n  look: {{{LOOK}, gain: [3]}}\n  watch: {{{LOOK.replace('head', 'hed')}}}\n"
        "actions: [look, watch]\n"
    )
    path = write(tmp_path, text)
    with pytest.raises(DiagnosticsError) as error:
        check_program(path, {"feature": "hue_1"}, Library(tmp_path))
    assert [d.code for d in error.value.diagnostics] == ["CB204", "CB205", "CB501"]


def references(tmp_path: Path, *bodies: str) -> list[object]:
    """Return the checked references of controllers of the right arm's tip."""
    tip = "potential: spring, feedback: right_arm.position, effector: right_arm.position"
    lines = [f"  c{i}: {{{tip}, {body}}}\n" for i, body in enumerate(bodies)]
    names = ", ".join(f"c{i}" for i in range(len(bodies)))
    text = f"parameters: {{up: 3 cm}}\ncontrollers:\n{''.join(lines)}actions: [{names}]\n"
    program = check_program(write(tmp_path, text))
    return [primitive.lead.reference for primitive in program.primitives.values()]


def test_parameters_stand_for_axes(tmp_path: Path) -> None:
    tip = "potential: spring, feedback: right_arm.position, effector: right_arm.position"
    text = (
        "parameters: {along: z, across: x}\n"
        f"controllers: {{c: {{{tip}, reference: [1 cm, 2 cm], axes: [$along, $across]}}}}\n"
        "actions: [c]\n"
    )
    program = check_program(write(tmp_path, text))
    assert program.primitives["c"].lead.axes == (0, 2)
    other = check_program(write(tmp_path, text), {"along": "y"})
    assert other.primitives["c"].lead.axes == (0, 1)


def test_references_relative_to_the_activation_or_a_resource(tmp_path: Path) -> None:
    found = references(
        tmp_path,
        "reference: here",
        'reference: "here + [1 cm, 0 cm, $up]"',
        "reference: here-2 cm, axes: [y]",
        'reference: "stereo.red + [0 m, 0 m, 0.1 m]"',
        "reference: stereo.red - $up, axes: [z]",
        "reference: [1 cm, 2 cm], axes: [z, x]",
    )
    assert found[0] == Relative(None, (0, 0, 0))
    assert found[1] == Relative(None, (0.01, 0, 0.03))
    assert found[2] == Relative(None, (0, -0.02, 0))
    red, above = found[3], found[4]
    assert isinstance(red, Relative) and isinstance(above, Relative)
    assert red.base is not None and red.base.name == "stereo.red" and red.offset == (0, 0, 0.1)
    assert above.offset == (0, 0, -0.03)
    # Coordinates follow the order of the axes, in any order of writing.
    assert found[5] == Literal((0.01, 0.0, 0.02))


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("reference: here + 2 N, axes: [z]", "CB506"),
        ("reference: here + 2 cm", "CB505"),
        ("reference: here + up, axes: [z]", "CB506"),
        ("reference: right_arm + 2 cm, axes: [z]", "CB504"),
        ("reference: stereo.rad + 2 cm, axes: [z]", "CB501"),
        ("reference: here, axes: []", "CB580"),
        ("reference: here, axes: [x, x]", "CB580"),
        (
            "reference: here + [1 cm, 2 cm], axes: [x, y], funnel: {height: 1 cm, within: 1 cm}",
            "CB58",
        ),
        ("reference: here, standoff: {clearance: 1 cm, least: 1 cm, most: 2 cm}", "CB583"),
    ],
)
def test_reference_that_does_not_fit_is_one_finding(tmp_path: Path, body: str, code: str) -> None:
    with pytest.raises(DiagnosticsError) as refused:
        references(tmp_path, body.replace("here + [1 cm, 2 cm]", "'here + [1 cm, 2 cm]'"))
    (diagnostic,) = refused.value.diagnostics
    assert diagnostic.code.startswith(code)


def test_parameters_stand_in_lists(tmp_path: Path) -> None:
    (found,) = references(tmp_path, "reference: [1 cm, $up, 0 cm]")
    assert found == Literal((0.01, 0.03, 0.0))
