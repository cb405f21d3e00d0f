"""Mutants of cbdsl: random small faults in its code, and which of them the fast tests notice.

A mutant is one change by an operator of cosmic-ray, made in a copy of the checkout. The tests of
the mutated file run first, then those of its package, then all fast ones; the first failure kills
it, if the same test passes without the mutant. A sample is judged by the exact interval of the
share that died. Known survivors are listed with their reason and count as survivors.

Run with ``make mutants``, or ``python -m tests.mutants --sample 20 --seed 3 --reach package``.
``--keep FILE --seconds 150`` runs a part and continues later.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from difflib import unified_diff
from math import inf
from pathlib import Path
from typing import Any

import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

from cbdsl.numeric.compiled import MARKS
from cbdsl.numeric.proportion import exact_interval

ROOT = Path(__file__).parents[1]
PACKAGES = ("control", "sensing", "runtime", "learning")
COPIED = (
    "cbdsl", "tests", "distributions", "reproduction", "benchmarks", "docs", "programs", "robots",
    "schemas", "knowledge",
)  # fmt: skip
FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "Makefile", "setup.sh")

#: Share of the mutants that tests have to notice.
LEAST = 0.9
#: Seconds after which a mutant has changed an end into none, which its tests notice, too.
PATIENCE = 300
PATIENCE_WITH_ALL = 1800
#: Tests that run: those of its package that mirror or import the mutated file, all of its package,
#: those elsewhere that import it and all of the four packages, too, or every fast one.
REACHES = ("file", "package", "packages", "all")

# One fault of each sort; other operators of cosmic-ray put many alike in the same place.
OPERATORS = tuple(
    f"core/{name}"
    for name in (
        *(f"ReplaceBinaryOperator_{pair}" for pair in (
            "Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_Mul", "Pow_Mul",
        )),
        *(f"ReplaceComparisonOperator_{pair}" for pair in (
            "Eq_NotEq", "NotEq_Eq", "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt",
            "Is_IsNot", "IsNot_Is",
        )),
        "ReplaceUnaryOperator_Delete_USub", "ReplaceUnaryOperator_Delete_Not", "AddNot",
        "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue",
        "ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "NumberReplacer",
        "ZeroIterationForLoop",
    )
)  # fmt: skip


@dataclass(frozen=True, order=True)
class Mutant:
    """Change of one file.

    Attributes:
        file: Path relative to the checkout's folder.
        operator: Name of an operator of cosmic-ray.
        occurrence: Index of the place that the operator changes, from 0.
    """

    file: str
    operator: str
    occurrence: int

    @property
    def code(self) -> str | None:
        """The file's mutated text, ``None`` where nothing would change."""
        source = (ROOT / self.file).read_text()
        mutated: str | None = mutate_code(source, get_operator(self.operator)(), self.occurrence)
        return mutated if mutated is not None and _is_another(source, mutated) else None

    @property
    def change(self) -> str:
        """The lines that differ, as a patch without its heading."""
        before, after = (ROOT / self.file).read_text(), self.code or ""
        lines = unified_diff(before.splitlines(), after.splitlines(), n=0, lineterm="")
        return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))


def _is_another(source: str, mutated: str) -> bool:
    """Return True if a text parses and differs from a source by more than annotations."""
    try:
        return _bare(source) != _bare(mutated)
    except SyntaxError:
        return False


def _bare(source: str) -> str:
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AnnAssign)):
            for name in ("returns", "annotation"):
                if getattr(node, name, None) is not None:
                    setattr(node, name, ast.Constant(None))
        if isinstance(node, ast.arg):
            node.annotation = None
        # An import for annotations alone.
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            node.test = ast.Constant(None)
    return ast.dump(tree)


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Yield all mutants of a file, place by place."""
    tree = get_ast(file.read_text())
    nodes = tuple(ast_nodes(tree))
    for name in OPERATORS:
        operator = get_operator(name)()
        places = sum(len(tuple(operator.mutation_positions(node))) for node in nodes)
        for occurrence in range(places):
            yield Mutant(file.relative_to(ROOT).as_posix(), name, occurrence)


def sample_of(packages: Sequence[str], size: int, seed: int) -> list[Mutant]:
    """Return random mutants of some packages, without mutants that leave the program unchanged."""
    files = [file for name in packages for file in sorted((ROOT / "cbdsl" / name).rglob("*.py"))]
    every = [mutant for file in files for mutant in mutants_of(file)]
    random.Random(seed).shuffle(every)
    changing = (mutant for mutant in every if mutant.code is not None)
    return [mutant for mutant, _ in zip(changing, range(size), strict=False)]


def suites_of(file: str, reach: str) -> list[list[str]]:
    """Return arguments of pytest, one list a process, so that a mutant is compiled once.

    Tests that mirror a file come first, then those of its package that import it, then the rest of
    its package. Those elsewhere that import it follow, and then the remaining tests within a reach.
    """
    _, package, *folders, name = Path(file).parts
    module = ".".join(("cbdsl", package, *folders, Path(name).stem))
    mirror = Path("tests", package, *folders, f"test_{name}").as_posix()
    of_package = _tests_of(package)
    imports = re.compile(rf"\b{re.escape(module)}\b")
    near = [
        *(each for each in of_package if each == mirror),
        *(each for each in of_package if imports.search(_text(each))),
    ]
    if reach != "file" or not near:
        near += of_package
    if reach in ("packages", "all"):
        near += [each for each in _tests_of("") if imports.search(_text(each))]
        near += [each for other in PACKAGES for each in _tests_of(other)]
    suites = [list(dict.fromkeys(near))]
    rest = ["-n", "2", "tests", "distributions", "reproduction/tests"]
    return [*suites, rest] if reach == "all" else suites


def _text(test: str) -> str:
    return (ROOT / test).read_text()


def _tests_of(package: str) -> list[str]:
    files = sorted((ROOT / "tests" / package).rglob("test_*.py"))
    return [file.relative_to(ROOT).as_posix() for file in files]


def copy_checkout(folder: Path) -> None:
    """Copy the files that tests read, with machine code, which is stamped with all its sources."""
    ignored = shutil.ignore_patterns("*.pyc")
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in FILES:
        shutil.copy(ROOT / name, folder / name)


class Copy:
    """Copy of the checkout that mutants are put into, one at a time.

    Args:
        folder: Folder of the copy.

    Attributes:
        failing: Tests that also fail without a mutant, and are left out from then on.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.failing: list[str] = []
        self._sound: set[str] = set()

    def killer(self, mutant: Mutant, reach: str) -> str | None:
        """Return the first test that a mutant fails and that passes without it.

        Returns:
            Its name in pytest, or the end of a process without a name; ``None`` for a survivor.

        Raises:
            SystemExit: Tests cannot even be read without it.
        """
        while True:
            by = self._first_failure_with(mutant, reach)
            if by is None or by in self._sound:
                return by
            # Where a process ended without a failed test, it was before all of them.
            test = "::" in by
            if self.first_failure([by] if test else ["--collect-only", *_tests_of("runtime")]):
                if not test:
                    raise SystemExit(f"without a mutant, too: {by}")
                sys.stdout.write(f"left out, since it fails without a mutant, too: {by}\n")
                self.failing.append(by)
                continue
            self._sound.add(by)
            return by

    def _first_failure_with(self, mutant: Mutant, reach: str) -> str | None:
        file, code = self.folder / mutant.file, mutant.code
        assert code is not None
        before = file.read_text()
        kernels = any(mark in before.encode() for mark in MARKS)
        suites = suites_of(mutant.file, reach)
        file.write_text(code)
        try:
            failures = (self.first_failure(suite, kernels=kernels) for suite in suites)
            return next((each for each in failures if each), None)
        finally:
            file.write_text(before)

    def first_failure(self, suite: Sequence[str], *, kernels: bool = False) -> str | None:
        """Return the first test that fails; a process that crashes or never ends counts as one.

        Args:
            suite: Arguments of pytest.
            kernels: True if machine code differs from the checkout's; it then goes into a temporary
            folder.
        """
        left_out = [f"--deselect={each}" for each in self.failing]
        command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        patience = PATIENCE if suite[-1] != "tests" else PATIENCE_WITH_ALL
        surroundings = os.environ | {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"}
        with tempfile.TemporaryDirectory() as compiled:
            if kernels:
                surroundings["NUMBA_CACHE_DIR"] = compiled
            try:
                done = subprocess.run(
                    [*command, *left_out, *suite],
                    cwd=self.folder,
                    env=surroundings,
                    capture_output=True,
                    text=True,
                    timeout=patience,
                    check=False,
                )
            except subprocess.TimeoutExpired:
                return f"no end within {patience} s"
        none = done.returncode == pytest.ExitCode.NO_TESTS_COLLECTED
        if none and not left_out:
            raise SystemExit(f"no tests: {done.stdout[-2000:]}")
        if none or done.returncode == 0:
            return None
        failed = re.search(r"^(?:FAILED|ERROR) (tests/.+?)(?: - |$)", done.stdout, re.MULTILINE)
        return failed[1] if failed else f"pytest ended with {done.returncode}"


def known_survivors() -> dict[tuple[str, str], str]:
    """Return the reasons why survivors live, by file and change."""
    survivors = tomllib.loads((ROOT / "tests" / "survivors.toml").read_text())["survivor"]
    return {(each["file"], each["change"].strip()): each["reason"] for each in survivors}


@dataclass
class Judgement:
    """Outcomes of mutants, kept line by line in a file to resume from.

    Attributes:
        reach: Reach of the tests that run.
        kept: Path of the file; ``None`` keeps nothing.
        rows: Fields of each mutant, ``change``, ``reach`` and ``by``, the test that killed it.
    """

    reach: str
    kept: Path | None
    rows: dict[Mutant, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        lines = self.kept.read_text().splitlines() if self.kept and self.kept.exists() else []
        for row in map(json.loads, lines):
            self.rows[Mutant(row["file"], row["operator"], row["occurrence"])] = row

    def is_judged(self, mutant: Mutant) -> bool:
        """Return True if the same change died, or survived all tests that would run."""
        row = self.rows.get(mutant)
        if row is None or row["change"] != mutant.change:
            return False
        return row["by"] is not None or REACHES.index(row["reach"]) >= REACHES.index(self.reach)

    def add(self, mutant: Mutant, by: str | None) -> None:
        """Keep the killer of a mutant, and print it."""
        row = {**asdict(mutant), "change": mutant.change, "reach": self.reach, "by": by}
        self.rows[mutant] = row
        if self.kept:
            with self.kept.open("a") as file:
                file.write(json.dumps(row) + "\n")
        said = f"dies     {mutant.file}: {by}" if by else f"SURVIVES {mutant.file}\n{mutant.change}"
        sys.stdout.write(f"{said}\n")
        sys.stdout.flush()


def judge(sample: Sequence[Mutant], judgement: Judgement, seconds: float) -> tuple[int, int]:
    """Return the numbers of dead and of judged mutants; begin none after some seconds."""
    died = of = 0
    begun = time.monotonic()
    reasons = known_survivors()
    with tempfile.TemporaryDirectory() as name:
        copy = Copy(Path(name))
        copy_checkout(copy.folder)
        for mutant in sample:
            reason = reasons.get((mutant.file, mutant.change.strip()))
            if reason:
                sys.stdout.write(f"survives {mutant.file}, known: {reason}\n{mutant.change}\n")
                of += 1
                continue
            if not judgement.is_judged(mutant):
                if time.monotonic() - begun > seconds:
                    continue
                judgement.add(mutant, copy.killer(mutant, judgement.reach))
            of += 1
            died += judgement.rows[mutant]["by"] is not None
    return died, of


def main() -> None:
    """Judge a sample; exits 1 where it refutes that the wanted share dies."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=100, help="how many mutants")
    parser.add_argument("--seed", type=int, default=0, help="which ones")
    parser.add_argument("--reach", choices=REACHES, default="all", help="tests that run")
    parser.add_argument("--keep", type=Path, help="file of the results, to go on from")
    parser.add_argument("--seconds", type=float, default=inf, help="none is begun after these")
    options = parser.parse_args()
    sample = sample_of(PACKAGES, options.sample, options.seed)
    died, of = judge(sample, Judgement(options.reach, options.keep), options.seconds)
    low, high = exact_interval(died, of)
    sys.stdout.write(f"{died} of {of} died: {100 * low:.1f} to {100 * high:.1f} %\n")
    sys.exit(high < LEAST)


if __name__ == "__main__":
    main()
