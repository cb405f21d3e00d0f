"""Data of uses: each use of a program has its own, also if another use has other arguments."""

from __future__ import annotations

import pytest

from cbdsl.program.uses import by_use, of_use, uses
from tests.program.test_dry_run import PROGRAMS, program_of


@pytest.mark.parametrize("name", PROGRAMS)
def test_of_use_returns_the_data_of_that_use(name: str) -> None:
    program = program_of(name)
    data = by_use(program, lambda each: (each.name, each.members, dict(each.parameters)))
    for use, each in uses(program):
        found = of_use(data, each.name, use)
        assert found == (each.name, each.members, dict(each.parameters)), use


def test_two_uses_with_other_arguments_have_an_entry_each() -> None:
    program = program_of("stack_three")
    data = by_use(program, lambda each: tuple(each.parameters.items()))
    stacks = [use for use, each in uses(program) if each.name == "stack"]
    assert len({of_use(data, "stack", use) for use in stacks}) == len(stacks) == 2
    alike = by_use(program, lambda each: each.name)
    assert alike.keys() == {each.name for _, each in uses(program)}


def test_by_use_leaves_out_programs_without_data() -> None:
    assert by_use(program_of("survey"), lambda _: None) == {}
