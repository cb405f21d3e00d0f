"""Mutants: their changes, the left-out ones, and one of the tick that dies."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests import mutants
from tests.mutants import (
    PACKAGES,
    ROOT,
    Copy,
    Judgement,
    Mutant,
    judge,
    known_survivors,
    mutants_of,
    sample_of,
    suites_of,
)

# Most of them copy a checkout and start its tests.
pytestmark = pytest.mark.slow

BASIS = ROOT / "cbdsl" / "control" / "basis.py"
CONTROL = ROOT / "tests" / "control"
#: Seed of the sample that is judged with the slow tests.
SEED = 0


def test_every_mutant_of_a_file_is_another_program() -> None:
    file = ROOT / "cbdsl" / "control" / "conditions" / "onset.py"
    texts = [mutant.code for mutant in mutants_of(file)]
    changed = [text for text in texts if text is not None]
    assert len(set(changed)) > 20
    assert file.read_text() not in changed


def test_mutants_leave_annotations_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    file = tmp_path / "one.py"
    file.write_text(
        "from typing import TYPE_CHECKING, Literal\n\nif TYPE_CHECKING:\n    import numpy\n\n\n"
        "def one(a: Literal[1]) -> Literal[2]:\n    return a\n"
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
    (package,) = suites_of("cbdsl/control/law.py", "package")
    assert package[0] == "tests/control/test_law.py"
    assert package[1] == "tests/control/potentials/test_harmonic.py"  # imports it, too
    assert set(package) == {
        file.relative_to(ROOT).as_posix() for file in CONTROL.rglob("test_*.py")
    }
    (journal,) = suites_of("cbdsl/storage/journal.py", "packages")
    assert journal[0] == "tests/storage/test_journal.py"
    imports_it = journal.index("tests/training/test_trial_work.py")
    assert imports_it < journal.index("tests/control/test_law.py")
    (near,) = suites_of("cbdsl/control/law.py", "file")
    assert near == package[: len(near)] and len(near) < len(package)
    (four,) = suites_of("cbdsl/control/law.py", "packages")
    assert four[: len(package)] == package
    assert {Path(each).parts[1] for each in four} == set(PACKAGES)
    assert suites_of("cbdsl/control/law.py", "all") == [
        four,
        ["-n", "2", "tests", "distributions", "reproduction/tests"],
    ]


def test_file_without_a_test_gets_the_tests_of_its_package() -> None:
    (suite,) = suites_of("cbdsl/runtime/modifiers/seek.py", "file")
    assert [suite] == suites_of("cbdsl/runtime/modifiers/seek.py", "package")


def test_known_survivors_are_changes_of_files_that_exist() -> None:
    for (file, change), reason in known_survivors().items():
        source = (ROOT / file).read_text()
        removed = [line[1:] for line in change.splitlines() if line.startswith("-")]
        assert removed and all(line in source for line in removed), f"{file}: {change}"
        assert reason


@pytest.mark.parametrize(
    ("asserted", "by"),
    [
        ("one(2) == 3", "tests/control/test_one.py::test_one"),
        ("one(0) == 0 or one(2)", None),
        ("one(2) == 3 or __import__('os')._exit(1)", "pytest ended with 1"),
    ],
)
def test_first_test_that_fails_kills(checkout: Path, asserted: str, by: str | None) -> None:
    write_test(checkout, f"    assert {asserted}\n")
    assert Copy(checkout).killer(one_of(checkout, "a - 1"), "file") == by
    assert (checkout / ONE).read_text() == TEXT


def test_mutant_that_cannot_be_imported_dies(checkout: Path) -> None:
    write_test(checkout, "    assert one(2) == 3\n")
    assert Copy(checkout).killer(one_of(checkout, "HALF = 1 * 2"), "file") is None
    assert (
        Copy(checkout).killer(one_of(checkout, "OTHER = 1 / 0"), "file")
        == "tests/control/test_one.py"
    )


def test_test_that_fails_without_a_mutant_kills_none(checkout: Path) -> None:
    write_test(checkout, "    assert one(2) == 4\n")
    copy = Copy(checkout)
    assert copy.killer(one_of(checkout, "a - 1"), "file") is None
    assert copy.failing == ["tests/control/test_one.py::test_one"]
    with (checkout / "tests" / "control" / "test_one.py").open("a") as file:
        file.write("\n\ndef test_other():\n    assert one(1) == 2\n")
    assert copy.killer(one_of(checkout, "a - 1"), "file") == f"{copy.failing[0][:-3]}other"


def test_results_are_kept_and_survivors_judged_again_by_more_tests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sample = sample_of(PACKAGES[-1:], 4, seed=1)
    ran: list[Mutant] = []

    def second_survives(_: Copy, mutant: Mutant, reach: str) -> str | None:
        ran.append(mutant)
        return None if mutant == sample[1] else "tests/test_one.py"

    monkeypatch.setattr(Copy, "killer", second_survives)
    monkeypatch.setattr(mutants, "copy_checkout", lambda folder: None)
    known = {(sample[3].file, sample[3].change.strip()): "it is all the same"}
    monkeypatch.setattr(mutants, "known_survivors", lambda: known)
    kept = tmp_path / "kept.jsonl"
    assert judge(sample, Judgement("file", kept), -1.0) == (0, 1)  # none is begun
    assert judge(sample, Judgement("file", kept), 100.0) == (2, 4)
    assert ran == sample[:3]
    assert "it is all the same" in capsys.readouterr().out
    assert judge(sample, Judgement("file", kept), 100.0) == (2, 4)
    assert ran == sample[:3]
    assert judge(sample, Judgement("all", kept), 100.0) == (2, 4)
    assert ran[3:] == [sample[1]]
    assert judge(sample, Judgement("package", kept), 100.0) == (2, 4)
    assert len(ran) == 4


def test_mutant_with_reversed_priorities_dies(tmp_path: Path) -> None:
    """Compile its code apart from the checkout's."""
    mutants.copy_checkout(tmp_path)
    turned = next(mutant for mutant in mutants_of(BASIS) if "-= along / basis" in mutant.change)
    copy = Copy(tmp_path)
    assert copy.killer(turned, "file") is not None
    assert copy.killer(harmless(), "file") is None


def test_some_mutants_of_a_sample_die() -> None:
    """Four mutants judge no share. That none dies has a chance of 1 in 100 where 7 of 10 do."""
    died, of = judge(sample_of(PACKAGES, 4, seed=SEED), Judgement("file", None), math.inf)
    assert of == 4
    assert died > 0


def harmless() -> Mutant:
    """Return a change of a sweep's bound, which has no effect on the results."""
    return next(mutant for mutant in mutants_of(BASIS) if "_SWEEPS = 21" in mutant.change)


ONE = Path("cbdsl", "control", "one.py")
TEXT = "HALF = 1 / 2\nOTHER = 1 / 1\n\n\ndef one(a):\n    return a + 1\n"


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a package of one file."""
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    (tmp_path / ONE).parent.mkdir(parents=True)
    for folder in ("cbdsl", "cbdsl/control"):
        (tmp_path / folder / "__init__.py").touch()
    (tmp_path / ONE).write_text(TEXT)
    return tmp_path


def write_test(checkout: Path, body: str) -> None:
    """Let a package of one file have a test."""
    file = checkout / "tests" / "control" / "test_one.py"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"from cbdsl.control.one import one\n\n\ndef test_one():\n{body}")


def one_of(checkout: Path, added: str) -> Mutant:
    """Return the mutant of a package of one file that adds some text."""
    every = mutants_of(checkout / ONE)
    return next(mutant for mutant in every if added in mutant.change)
