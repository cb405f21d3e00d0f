"""Programs with steps in place of their policies decide each state in the same way."""

from __future__ import annotations

import itertools
import random
from pathlib import Path

import pytest

from cbdsl.checking.program import check_program
from cbdsl.checking.rules.flow import active_members, values_of
from cbdsl.checking.step_conversion import with_steps
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.policy_table import PolicyTable
from cbdsl.types.state import matches
from cbdsl.yaml_text.library import Library, shipped
from cbdsl.yaml_text.reader import read

PROGRAMS = Library(shipped()).names(ProgramDocument)

#: Values of an action's members that are drawn if there are more.
MOST_VALUES = 1_000


def convert(path: Path, folder: Path) -> CheckedProgram:
    program = check_program(path)
    text = with_steps(path.read_text("utf-8"), read(path, ProgramDocument).document, program)
    copy = folder / path.name
    copy.write_text(text, encoding="utf-8")
    return check_program(copy, library=Library(path.parents[1]))


def conclusion(program: CheckedProgram, table: PolicyTable, state: str) -> tuple[str, str | None]:
    if any(matches(pattern, state) for pattern in program.success):
        return "success", ""
    for pattern in program.failure:
        if matches(pattern, state):
            return "failure", program.reasons.get(pattern, "")
    return "action", table.find(state)


@pytest.mark.parametrize("name", PROGRAMS)
def test_with_steps_of_a_shipped_program_decides_all_states_alike(
    name: str, tmp_path: Path
) -> None:
    before = check_program(name, library=Library(shipped()))
    after = convert(Library(shipped()).locate(ProgramDocument, name), tmp_path)
    assert {action.name for action in after.actions} == {each.name for each in before.actions}
    tables = PolicyTable(before.policy), PolicyTable(after.policy)
    for action in before.actions:
        if action.name not in before.policy.values():
            continue
        own = active_members(action)
        values = [values_of(member, before, tells=False) for member in own]
        chosen = list(itertools.islice(itertools.product(*values), 3**7))
        if len(chosen) > MOST_VALUES:
            draw = random.Random(0)
            chosen = [tuple(map(draw.choice, values)) for _ in range(MOST_VALUES)]
        for letters in chosen:
            of_member = dict(zip(own, letters, strict=True))
            one, other = (
                conclusion(program, table, "".join(of_member.get(m, "X") for m in program.members))
                for program, table in zip((before, after), tables, strict=True)
            )
            assert one == other, (action.name, of_member)
    for program, table in zip((before, after), tables, strict=True):
        assert table.find("X" * len(program.members)) == tables[0].find("X" * len(before.members))


DOCUMENT = """\
cbdsl: 1
kind: program
name: look
robot: dexter
# Where to look.
controllers:
  search: {potential: spring, reference: head.uniform, feedback: head, effector: head}
  track: {potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.motion, effector: head}
actions: [search, track, search ◁ track]  # all of them
# search, track
policy:
  XX: search
  # Look again, from elsewhere.
  0X: search
  1X: search ◁ track
  "*-": search ◁ track
  "*0": search ◁ track
success: ["*1"]  # found
limits: {transitions: 9}
"""


def test_with_steps_keeps_comments_and_drops_the_list_of_members(tmp_path: Path) -> None:
    path = tmp_path / "look.yaml"
    path.write_text(DOCUMENT, encoding="utf-8")
    text = with_steps(DOCUMENT, read(path, ProgramDocument).document, check_program(path))
    assert (
        text[text.index("feedback: cyclopean") :].partition("\n")[2]
        == """\

# all of them
# found
steps:
  # Look again, from elsewhere.
  search:
    exits:
      - search at rest: track
  track:
    do: search ◁ track
    exits:
      - track at rest: succeed

limits: {transitions: 9}
"""
    )
    path.write_text(text, encoding="utf-8")
    again = with_steps(text, read(path, ProgramDocument).document, check_program(path))
    assert again == text
