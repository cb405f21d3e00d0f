"""Shipped schemas choose successful allocations, and report before moving if none exists."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.program_digest import policy_digest
from cbdsl.checking.session import Session
from cbdsl.documents.schema import SchemaDocument
from cbdsl.yaml_text.library import Library
from tests.cli.test_main import cb
from tests.conftest import ROOT

SCHEMAS = sorted((ROOT / "knowledge" / "schemas").glob("*.yaml"))
RUN = ("--stage", "near_and_far_training", "--backend", "kinematic", "--json")
USING = """\
cbdsl: 1
kind: program
name: using
robot: dexter
use: {pick: {program: reachtouch, schema: reachtouch}}
controllers:
  nod: {potential: spring, reference: [0 rad, 0.5 rad], feedback: head, effector: head}
actions: [pick, nod]
policy: {XX: pick, 0X: pick, -X: nod, X0: nod}
"""


@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.stem)
def test_shipped_schema_has_no_diagnostics(path: Path) -> None:
    assert check_document(path, Session(Library(ROOT))) == []


@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.stem)
def test_provenance_of_a_schema_names_the_shipped_policies(path: Path) -> None:
    """Require them: a composition's leading part decides if both hands can stand in."""
    library = Library(ROOT)
    provenance = library.read(path, SchemaDocument).document.provenance
    assert provenance is not None and provenance.policies
    for name, digest in provenance.policies.items():
        assert digest == policy_digest(name, path, library), name


def test_reachtouch_with_its_schema_acts_only_on_reachable_objects(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("run", "reachtouch", "--schema", "reachtouch", *RUN)
    cb(monkeypatch, *words, "--episodes", "20", "--seed", "8700000")
    episodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    far = [each for each in episodes if each["context"] == "far"]
    near = [each for each in episodes if each["context"] != "far"]
    assert len(far) >= 5 and len(near) >= 5
    for each in far:
        assert "reward is unlikely here" in each["ending"] and not each["rewarded"]
        # The first action is chosen before anything is seen, and lasts one tick.
        assert set(each["actions"][1:]) <= {"searchtrack"}
    assert sum(each["rewarded"] for each in near) >= 0.9 * len(near)
    used = {word for each in near for word in each["actions"][-1].split(" with ")[1:]}
    assert len(used) >= 2, "not always the same resources"


def test_schema_that_predicts_no_reward_reads_undefined_to_its_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "using.yaml"
    path.write_text(USING, encoding="utf-8")
    cb(monkeypatch, "run", str(path), *RUN, "--episodes", "8", "--seed", "8700000")
    episodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    far = [each for each in episodes if each["context"] == "far"]
    assert far
    for each in far:
        states = each["predicates"]
        assert states[states.index("-X") + 1] == "X0" and each["actions"][-1] == "nod"


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "bullet", "mujoco"])
def test_both_hands_press_on_a_fixed_object_without_slipping(
    backend: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Palms that are allowed to turn aside press past it, and fast ones bounce off it."""
    pytest.importorskip({"bullet": "pybullet"}.get(backend, "mujoco"))
    words = ("run", "reachtouch_bimanual", "--stage", "near_and_far_training", "--context", "large")
    seen = ("--backend", backend, "--cameras", "ideal", "--json")
    cb(monkeypatch, *words, *seen, "--episodes", "4", "--seed", "8700100")
    episodes = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert sum(each["rewarded"] for each in episodes) >= 3
