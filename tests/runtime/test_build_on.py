"""Outcomes of ``build_on``: an object set on a stack, and bounds that it does not meet."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbdsl
from tests.conftest import ROOT

_PROGRAM = ROOT / "programs" / "build_on.yaml"
_STAYS = "stays: seen_still($goal, $base)"
_STILLER = (
    "stays: {potential: spring, reference: here, feedback: left.$goal.to.$base, effector: head,"
    " gain: 1 /s, quiescence: {rate: 1e-14, window: 1 s, tolerance: 0.1}}"
)
_CONTEXT = "red_box_on_purple_box_on_blue_box"


@pytest.mark.parametrize(
    ("bound", "stricter", "outcome", "reason"),
    [
        ("8 cm, 1 s)", "8 cm, 1 s)", "success", ""),
        ("8 cm, 1 s)", "1 mm, 1 s)", "failure", "the object is not above the stack"),
        (_STAYS, _STILLER, "failure", "the constellation of the stack did not stay as it was"),
    ],
)  # fmt: skip
def test_build_on_states_an_outcome_whether_or_not_its_bounds_are_met(
    tmp_path: Path, bound: str, stricter: str, outcome: str, reason: str
) -> None:
    text = _PROGRAM.read_text()
    assert bound in text
    program = tmp_path / _PROGRAM.name
    program.write_text(text.replace(bound, stricter))
    request = cbdsl.load(program, values={"feature": "red"}, folder=ROOT)
    # With this seed, a head that watches the upper box changes the constellation too much.
    result, *_ = cbdsl.run(
        request, seed=8_110_021, context=_CONTEXT, backend="mujoco", cameras="ideal"
    )
    assert result.outcome == outcome
    assert reason in result.ending
