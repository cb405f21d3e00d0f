"""Random edits of shipped programs: each one that is faulty by an independent search is found."""

from __future__ import annotations

import pytest

from benchmarks.program_mutants import Search, findings, mutants, programs_with_steps


def check(count: int, seed: int) -> int:
    """Compare findings with the search, and return the number of faulty mutants."""
    faulty = 0
    for mutant in mutants(count, seed):
        faults = Search(mutant.document).faults()
        faulty += bool(faults)
        assert findings(mutant) or not faults, (mutant.program, mutant.edit, faults)
    return faulty


@pytest.mark.parametrize("name", programs_with_steps())
def test_search_finds_no_fault_in_a_shipped_program(name: str) -> None:
    assert Search(programs_with_steps()[name]).faults() == []


def test_validate_finds_faulty_steps_of_a_few_mutants() -> None:
    assert check(20, seed=2) > 0


@pytest.mark.slow
def test_validate_finds_faulty_steps_of_100_mutants() -> None:
    assert check(100, seed=3) > 10
