"""Programs under policies that were learned for them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.program import check_program
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.program.binding import internal_models
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource import GaussianSample
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

SHIPPED = {
    name: (ROOT / "programs" / f"{name}.yaml").read_text("utf-8")
    for name in ("searchtrack", "reachtouch")
}
LEARNED = """cbdsl: 1
kind: policy
name: learned
program: searchtrack
predicates: [search, track]
policy: {XX: track, "X-": search, "0X": search, "1X": track, X0: track}
models: {head.uniform: looks}
"""
LOOKS = """cbdsl: 1
kind: model
name: looks
robot: dexter
effector: head
density: {form: gaussian, mean: [0.1, 0.9], deviation: [0.2, 0.1], uniform: 0.25}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write REACHTOUCH, which uses SEARCHTRACK with its learned policy."""
    using = SHIPPED["reachtouch"].replace("policy: searchtrack_table", "policy: learned")
    files = {
        "programs/searchtrack.yaml": SHIPPED["searchtrack"],
        "programs/reachtouch.yaml": using,
        "knowledge/policies/learned.yaml": LEARNED,
        "knowledge/models/looks.yaml": LOOKS,
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def checked(folder: Path) -> CheckedProgram:
    return check_program(folder / "programs" / "reachtouch.yaml", {}, Library(folder))


def digest(folder: Path) -> str:
    return program_digest(folder / "programs" / "reachtouch.yaml", Library(folder)).sha256


def test_used_program_runs_under_its_learned_policy_and_draws_from_its_models(
    folder: Path,
) -> None:
    used = next(action.program for action in checked(folder).actions if action.program)
    assert used.policy["XX"] == "track" and "**" not in used.policy
    source = internal_models(used)["head.uniform"].source
    assert source == GaussianSample("head", (0.1, 0.9), (0.2, 0.1), 0.25)


@pytest.mark.parametrize(
    ("file", "old", "new", "code"),
    [
        ("knowledge/policies/learned.yaml", "program: searchtrack", "program: reachtouch", "CB626"),
        ("knowledge/policies/learned.yaml", "X0: track", "X0: trak", "CB613"),
        ("knowledge/policies/learned.yaml", "head.uniform: looks", "head.unifrm: looks", "CB623"),
        ("knowledge/models/looks.yaml", "[0.1, 0.9]", "[0.1]", "CB631"),
        ("knowledge/models/looks.yaml", "kind: model", "kind: modl", "CB206"),
        ("programs/reachtouch.yaml", "policy: learned", "policy: lerned", "CB625"),
    ],
)
def test_unsuitable_knowledge_keeps_the_program_from_running(
    folder: Path, file: str, old: str, new: str, code: str
) -> None:
    change(folder / file, old, new)
    with pytest.raises(DiagnosticsError) as caught:
        checked(folder)
    assert code in {diagnostic.code for diagnostic in caught.value.diagnostics}


@pytest.mark.parametrize(
    ("file", "old", "new", "differs"),
    [
        (
            "programs/reachtouch.yaml",
            "rate: 5e-4, window: 0.5 s",
            "rate: 5e-4, window: 0.6 s",
            True,
        ),
        (
            "programs/reachtouch.yaml",
            "rate: 5e-4, window: 0.5 s",
            "rate: 5e-4, window: 500 ms",
            False,
        ),
        ("programs/reachtouch.yaml", "  XXX: reach ◁ touch", "  XXX: searchtrack", False),
        ("programs/reachtouch.yaml", "stage: table_right", "stage: absent", False),
        ("programs/reachtouch.yaml", "Look for an object", "Look for something", False),
        ("programs/searchtrack.yaml", "gain: 8 /s", "gain: 4 /s", True),
        ("programs/searchtrack.yaml", '"*1": search', '"*1": track', False),
        ("knowledge/policies/learned.yaml", "X0: track", "X0: search", True),
        (
            "knowledge/policies/learned.yaml",
            "models:",
            "values: {XX: {track: 0.5}}\nmodels:",
            False,
        ),
        ("knowledge/models/looks.yaml", "0.25", "0.3", True),
    ],
)
def test_digest_changes_with_inputs_of_learning(
    folder: Path, file: str, old: str, new: str, differs: bool
) -> None:
    before = digest(folder)
    change(folder / file, old, new)
    assert (digest(folder) != before) == differs


def test_policies_that_run_inside_of_a_program_have_digests_of_their_own(folder: Path) -> None:
    program = folder / "programs" / "outer.yaml"
    text = SHIPPED["searchtrack"].replace("name: searchtrack", "name: outer")
    use = "use: {grasp: {program: reachtouch}}\ncontrollers:"
    program.write_text(text.replace("controllers:", use, 1), encoding="utf-8")
    before = program_digest(program, Library(folder)).policies
    assert list(before) == ["learned"]
    change(folder / "knowledge/models/looks.yaml", "0.25", "0.3")
    assert program_digest(program, Library(folder)).policies != before
    change(folder / "programs/reachtouch.yaml", "    policy: learned\n", "")
    assert program_digest(program, Library(folder)).policies == {}


def test_policy_of_a_used_program_matters_where_no_other_takes_its_place(folder: Path) -> None:
    change(folder / "programs/reachtouch.yaml", "    policy: learned\n", "")
    before = digest(folder)
    change(folder / "programs/searchtrack.yaml", '"*1": search', '"*1": track')
    assert digest(folder) != before
