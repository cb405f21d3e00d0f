"""States of policies that cannot occur."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.types.potential import POTENTIALS
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

HAND = "feedback: left_arm.position, effector: left_arm"
PROGRAM = """cbdsl: 1
kind: program
name: move
robot: dexter
controllers:
  go: {{{go}}}
actions: [go]
policy: {{X: go, "0": go, "-": go}}
"""


@pytest.mark.parametrize(
    ("go", "is_impossible"),
    [
        (f"potential: spring, reference: right_arm.position, {HAND}", True),
        (f"potential: spring, reference: stereo.sat_10, {HAND}", False),
        # A tip has no direction to the point where it is.
        (
            "potential: look_at, reference: right_arm.position, feedback: left_arm.pose, "
            "effector: left_arm",
            False,
        ),
    ],
)
def test_policy_for_undefined_warns_if_the_potential_is_always_defined(
    go: str, is_impossible: bool, tmp_path: Path
) -> None:
    file = tmp_path / "programs" / "move.yaml"
    file.parent.mkdir()
    file.write_text(PROGRAM.format(go=go), encoding="utf-8")
    codes = {each.code for each in check_document(file, Session(Library(ROOT)))}
    assert ("CB717" in codes) == is_impossible
    assert all(code.startswith("CB7") for code in codes)


def test_only_residuals_are_defined_for_all_values() -> None:
    total = {name for name, entry in POTENTIALS.items() if entry.total}
    assert total == {"spring", "at_most", "at_least", "range"}
    assert all(POTENTIALS[name].residual for name in total)
