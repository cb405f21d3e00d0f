"""Impedance gauge: it finds the tests of a program and of the programs that it uses."""

from __future__ import annotations

import pytest

from cbdsl.checking.program import check_program
from cbdsl.training.impedance_gauge import ImpedanceGauge


@pytest.mark.parametrize(
    ("program", "listens"),
    [("impedance", True), ("study", True), ("stand", False), ("reachtouch", False)],
)
def test_gauge_listens_to_programs_with_tests(program: str, listens: bool) -> None:
    assert ImpedanceGauge(check_program(program)).listens is listens


def test_profile_before_any_tick_is_incomplete() -> None:
    assert not ImpedanceGauge(check_program("study")).profile.is_whole
