"""Decision trees of documents compare as they are written."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.api.reading.relations import read_relation_tree
from cbdsl.types.decision_tree import decide
from cbdsl.yaml_text.library import Library

DOCUMENT = """\
cbdsl: 1
name: soft
kind: relations
robot: dexter
program: impedance
tree: {{if: dRz {sign} 0.5 N m/rad, then: 'yes', else: 'no'}}
samples: {{'yes': [], 'no': []}}
"""


@pytest.mark.parametrize(
    ("sign", "answers"), [(">", ["no", "no", "yes"]), ("<", ["yes", "no", "no"])]
)
def test_read_of_a_question_excludes_its_threshold(
    tmp_path: Path, sign: str, answers: list[str]
) -> None:
    file = tmp_path / "soft.yaml"
    file.write_text(DOCUMENT.format(sign=sign), "utf-8")
    tree = read_relation_tree(str(file), Library())
    assert [decide(tree, {"dRz": value}) for value in (0.4, 0.5, 0.6)] == answers
