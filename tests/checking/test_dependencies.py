"""Documents that programs name, with and without the packages that bring their kinds."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.documents.kinds import KINDS
from cbdsl.types.potential import POTENTIALS
from cbdsl.yaml_text.library import Library

NETWORK_PROGRAM = """\
cbdsl: 1
kind: program
name: follow
robot: dexter
models: {net: moved}
controllers:
  policy: {potential: learned, reference: right_arm.net, feedback: right_arm.position,
    effector: right_arm.position}
actions: [policy]
policy: {"*": policy}
"""


def test_program_of_a_network_without_the_extra_has_one_finding_that_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for registry in (POTENTIALS.registry, KINDS):
        monkeypatch.setattr(registry, "_offers", {})
        monkeypatch.setattr(registry, "_loaded", {})
    (tmp_path / "follow.yaml").write_text(NETWORK_PROGRAM)
    (finding,) = check_document(tmp_path / "follow.yaml", session=Session(Library(tmp_path)))
    assert finding.code == "CB502" and "pip install 'cbdsl[onnx]'" in finding.message
