"""Outcomes of ``build_on``: an object set on a stack, and bounds that it does not meet."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbdsl
from cbdsl.program.controller import Relative
from cbdsl.types.resource import ConstellationSignal
from tests.conftest import ROOT

_PROGRAM = ROOT / "programs" / "build_on.yaml"
_STAYS = "stays: seen_still($goal, $base)"
_STILLER = (
    "stays: {potential: spring, reference: here, feedback: left.$goal.to.$base, effector: head,"
    " gain: 1 /s, quiescence: {rate: 1e-14, window: 1 s, tolerance: 0.1}}"
)
_CONTEXT = "red_box_on_purple_box_on_blue_box"


@pytest.mark.parametrize(
    ("seed", "bound", "stricter", "outcome", "reason"),
    [
        # With these seeds, a head that goes on watching the stack changes its constellation.
        (8_110_016, "8 cm, 1 s)", "8 cm, 1 s)", "success", ""),
        (8_300_003, "8 cm, 1 s)", "8 cm, 1 s)", "success", ""),
        (8_110_021, "8 cm, 1 s)", "1 mm, 1 s)", "failure", "the object is not above the stack"),
        (8_110_021, _STAYS, _STILLER, "failure", "the constellation of the stack did not stay"),
    ],
)  # fmt: skip
def test_build_on_states_an_outcome_whether_or_not_its_bounds_are_met(
    tmp_path: Path, seed: int, bound: str, stricter: str, outcome: str, reason: str
) -> None:
    text = _PROGRAM.read_text()
    assert bound in text
    program = tmp_path / _PROGRAM.name
    program.write_text(text.replace(bound, stricter))
    request = cbdsl.load(program, values={"feature": "red"}, folder=ROOT)
    result, *_ = cbdsl.run(request, seed=seed, context=_CONTEXT, backend="mujoco", cameras="ideal")
    assert result.outcome == outcome
    assert reason in result.ending


def test_action_that_compares_blobs_holds_the_head_that_carries_the_camera() -> None:
    compared = 0
    for path in sorted((ROOT / "programs").glob("*.yaml")):
        program = cbdsl.load(path, folder=ROOT).program
        for action in program.actions:
            sources = [each.feedback.source for each in action.controllers]
            compares = any(isinstance(source, ConstellationSignal) for source in sources)
            if compares and action.name in program.policy.values():
                compared += 1
                held = [each for each in action.controllers if each.feedback.name == "head"]
                assert any(isinstance(each.reference, Relative) for each in held), action.name
    assert compared == 4
