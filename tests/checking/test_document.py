"""Bad documents, each with its expected diagnostics in its last lines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.checking.suppression import apply_suppressions
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.text_format import render
from cbdsl.yaml_text.library import Library, shipped

BAD = Path(__file__).parent / "bad"
SHIPPED = sorted(
    p for folder in ("robots", "programs") for p in (shipped() / folder).rglob("*.yaml")
)


def text_of(path: Path) -> str:
    return path.read_text("utf-8", errors="replace")  # one of them is not UTF-8


CASES = sorted(path for path in BAD.rglob("*.yaml") if "# finds" in text_of(path))


@pytest.fixture(scope="module")
def session() -> Session:
    """Return the session of all cases, so that the robots are read once."""
    return Session(Library(BAD))


def diagnostics(path: Path, session: Session) -> list[Diagnostic]:
    return apply_suppressions(check_document(path, session=session), [path], session.library)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_diagnostics_of_a_bad_document_equal_its_comment(path: Path, session: Session) -> None:
    wanted = re.findall(r"^# finds (.*)$", text_of(path), re.MULTILINE)
    found = []
    for diagnostic in diagnostics(path, session):
        place, message = diagnostic.place, diagnostic.message.replace(f"{BAD}/", "")
        message = re.sub(r"\S*tests/checking/bad/", "", message)
        elsewhere = Path(place.file).name
        where = "" if elsewhere == path.name else f"{elsewhere}:"
        found.append(f"{where}{place.line}:{place.column} {diagnostic.code} {message}")
    assert found == wanted


#: Cases with several diagnostics, and the reason for each group: a correction leaves the others.
SEVERAL = {
    "the same kind of mistake in several places": """
        words_for_quantities background_unknown compared_with_itself elbow_bent_backwards
        field_obstacle_shape
        funnel_below half_a_standoff light_touch short_windows beside_the_table
        guard_in_the_noise
        looks_too_far negative_radius standoff_behind alias_hides_a_channel alias_of_nothing
        far_behind negative_constants no_contact_of_nothing no_speed_at_all
        posture_named_position surface_of_nothing task_speed unknown_joint window_of_a_task
    """,
    "several mistakes, each of its own kind": """
        other_predicates wrong_letters field_obstacles field_workspace many_at_once
        several_faults several_keys several_states half_contexts joint_unknown robot_unknown
        unknown_hand unknown_thing two_errors_of_a_reference base_moves camera_faults
        channel_faults coupling_faults gains_of_one load_cell_faults no_normal
        posture_faults sensor_faults task_faults unknown_renderer broken_and_wrong
        key_meant_by_another
        mujoco_constants octal_and_unknown robot_unknown_and_more thing_is_broken broken_effector
        rate_and_joint states_with_stars invisible_and_unknown
        joints_of_all_kinds success_of_what_is_never_undefined pairs_of_things compared_channels
    """,
    "mistakes of another document": "faulty_stage robot_is_faulty robot_is_broken",
    "one key too few, and one too many": "shape_incomplete",
    "an ignore that silences nothing, and what it should silence": "ignore_everything",
    "a wrong name and a use of itself": "uses_itself_under_another_name",
}


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_bad_document_with_one_mistake_has_one_diagnostic(path: Path, session: Session) -> None:
    justified = {name for names in SEVERAL.values() for name in names.split()}
    assert (len(diagnostics(path, session)) > 1) == (path.stem in justified)


def test_at_least_350_bad_documents_exist() -> None:
    assert len(CASES) >= 350


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_caret_of_a_diagnostic_is_inside_its_line(path: Path, session: Session) -> None:
    for diagnostic in diagnostics(path, session):
        text = text_of(Path(diagnostic.place.file))
        lines = render(diagnostic, text).split("\n")
        snippet = [line for line in lines if re.match(r" *\d+ \| ", line)]
        carets = [line for line in lines if re.match(r" +\| \s*\^+$", line)]
        assert len(snippet) == len(carets)
        for source, caret in zip(snippet, carets, strict=True):
            assert len(caret) <= len(source) + 1


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_documents_have_no_diagnostics(path: Path) -> None:
    session = Session()
    # Suppressions without a finding are diagnostics themselves.
    assert apply_suppressions(check_document(path, session), [path], session.library) == []
    assert path.stem == re.search(r"^name: (\w+)$", path.read_text("utf-8"), re.MULTILINE)[1]  # type: ignore[index]
