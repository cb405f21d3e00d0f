"""Mutants: what is changed, what is left out, and that one of the tick dies."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import mutants
from tests.mutants import PACKAGES, ROOT, Mutant, equivalents, mutants_of, sample_of, suites_of

LAW = ROOT / "cbdsl" / "control" / "composition.py"


def test_every_mutant_of_a_file_is_another_program() -> None:
    texts = [mutant.code for mutant in mutants_of(LAW)]
    changed = [text for text in texts if text is not None]
    assert len(set(changed)) > 100
    assert LAW.read_text() not in changed


def test_annotations_are_no_behaviour(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    file = tmp_path / "one.py"
    file.write_text(
        "from typing import Literal\n\n\ndef one(a: Literal[1]) -> Literal[2]:\n    return a\n"
    )
    assert all(mutant.code is None for mutant in mutants_of(file))
    file.write_text("def one(a):\n    return a + 1\n")
    assert any(mutant.code for mutant in mutants_of(file))


def test_samples_are_drawn_from_all_packages_and_repeat() -> None:
    sample = sample_of(PACKAGES, 60, seed=2)
    assert {Path(mutant.file).parts[1] for mutant in sample} == set(PACKAGES)
    few = PACKAGES[-1:]
    assert sample_of(few, 20, seed=2) == sample_of(few, 20, seed=2) != sample_of(few, 20, seed=3)


def test_nearest_tests_come_first() -> None:
    suites = suites_of("cbdsl/control/law.py", "all")
    assert suites[0] == ["tests/control/test_law.py"]
    assert suites[1] == ["tests/control"] and suites[2][-1] == "tests"
    assert suites_of("cbdsl/control/law.py", "package") == suites[:2]


def test_known_survivors_are_changes_of_files_that_exist() -> None:
    for (file, change), reason in equivalents().items():
        source = (ROOT / file).read_text()
        removed = [line[1:] for line in change.splitlines() if line.startswith("-")]
        assert removed and all(line in source for line in removed), f"{file}: {change}"
        assert reason


@pytest.mark.slow
def test_a_priority_that_is_turned_round_dies(tmp_path: Path) -> None:
    mutants.copy_checkout(tmp_path)
    turned = next(mutant for mutant in mutants_of(LAW) if "along / basis" in mutant.change)
    assert not mutants.survives(turned, tmp_path, "package")
    assert mutants.survives(harmless(), tmp_path, "package")


def harmless() -> Mutant:
    """A change of a sweep's bound, which one sweep more or less does not reach."""
    return next(mutant for mutant in mutants_of(LAW) if "_SWEEPS = 21" in mutant.change)
