"""Mutants of cbdsl: random small faults in its code, and which of them the fast tests notice.

A mutant is one change by an operator of cosmic-ray, made in a copy of the checkout. The tests of
the mutated file run first, then those of its package, then all fast ones; the first failure kills
it. A sample of them is judged by the exact interval of the share that died. Run with ``make
mutants``, or ``python -m tests.mutants --sample 20 --seed 3 --reach package``.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from difflib import unified_diff
from pathlib import Path
from typing import Any

import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

from cbdsl.numeric.proportion import exact_interval

ROOT = Path(__file__).parents[1]
PACKAGES = ("control", "sensing", "runtime", "learning")
COPIED = ("cbdsl", "tests", "benchmarks", "docs", "programs", "robots", "schemas", "knowledge")
FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "Makefile", "setup.sh")

#: Share of the mutants that tests have to notice.
LEAST = 0.9
#: Seconds after which a mutant has changed an end into none, which its tests notice, too.
PATIENCE = 900

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
    """One change of one file.

    Attributes:
        file: from the checkout's folder.
        operator: of cosmic-ray.
        occurrence: which of the places that the operator can change, from 0.
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
    """Whether a text is a program, and another one than a source but for annotations."""
    try:
        return _bare(source) != _bare(mutated)
    except SyntaxError:
        return False


def _bare(source: str) -> str:
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AnnAssign)):
            for field in ("returns", "annotation"):
                if getattr(node, field, None) is not None:
                    setattr(node, field, ast.Constant(None))
        if isinstance(node, ast.arg):
            node.annotation = None
    return ast.dump(tree)


def mutants_of(file: Path) -> Iterator[Mutant]:
    """All mutants of a file, place by place."""
    tree = get_ast(file.read_text())
    nodes = tuple(ast_nodes(tree))
    for name in OPERATORS:
        operator = get_operator(name)()
        places = sum(len(tuple(operator.mutation_positions(node))) for node in nodes)
        for occurrence in range(places):
            yield Mutant(file.relative_to(ROOT).as_posix(), name, occurrence)


def sample_of(packages: Sequence[str], size: int, seed: int) -> list[Mutant]:
    """Random mutants of some packages, without those that are the same program."""
    files = [file for name in packages for file in sorted((ROOT / "cbdsl" / name).rglob("*.py"))]
    every = [mutant for file in files for mutant in mutants_of(file)]
    random.Random(seed).shuffle(every)
    changing = (mutant for mutant in every if mutant.code is not None)
    return [mutant for mutant, _ in zip(changing, range(size), strict=False)]


def suites_of(file: str, reach: str) -> list[list[str]]:
    """Arguments of pytest, tests that are nearest to a file first.

    Args:
        reach: ``package`` for those of the file and of its package, ``all`` for all fast ones too.
    """
    _, *folders, name = Path(file).parts
    mirror = Path("tests", *folders, f"test_{name}")
    suites = [[str(mirror)]] if (ROOT / mirror).exists() else []
    suites.append([f"tests/{folders[0]}"])
    if reach == "all":
        suites.append(["-n", "2", "tests"])
    return suites


def copy_checkout(folder: Path) -> None:
    """Copy what tests read, without results and compiled code."""
    ignored = shutil.ignore_patterns("__pycache__", "*.nbc", "*.nbi")
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in FILES:
        shutil.copy(ROOT / name, folder / name)


def survives(mutant: Mutant, folder: Path, reach: str) -> bool:
    """Whether all tests pass in a copy of the checkout with the mutant in it."""
    file, code = folder / mutant.file, mutant.code
    assert code is not None
    before = file.read_text()
    file.write_text(code)
    try:
        return all(_passes(suite, folder) for suite in suites_of(mutant.file, reach))
    finally:
        file.write_text(before)


def _passes(suite: Sequence[str], folder: Path) -> bool:
    """Whether tests pass; a process that crashes has noticed the mutant, too."""
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *suite]
    surroundings = os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=surroundings,
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    if done.returncode in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
        raise SystemExit(f"pytest ended with {done.returncode}: {done.stdout.decode()[-2000:]}")
    return done.returncode == 0


def equivalents() -> dict[tuple[str, str], str]:
    """Known survivors that no test can notice: the reason, by file and change."""
    survivors = tomllib.loads((ROOT / "tests" / "survivors.toml").read_text())["survivor"]
    return {(each["file"], each["change"].strip()): each["reason"] for each in survivors}


def judge(size: int, seed: int, reach: str, kept: Path | None) -> list[dict[str, Any]]:
    """Results of a sample, those that a file keeps from before first."""
    lines = kept.read_text().splitlines() if kept and kept.exists() else []
    rows = [json.loads(line) for line in lines]
    done = {(row["file"], row["operator"], row["occurrence"]) for row in rows}
    excused = equivalents()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy_checkout(folder)
        for mutant in sample_of(PACKAGES, size, seed):
            key = (mutant.file, mutant.operator, mutant.occurrence)
            if key in done or (mutant.file, mutant.change.strip()) in excused:
                continue
            alive = survives(mutant, folder, reach)
            rows.append({**asdict(mutant), "change": mutant.change, "survives": alive})
            sys.stdout.write(f"{'SURVIVES' if alive else 'dies':9}{mutant.file}\n")
            if alive:
                sys.stdout.write(f"{mutant.change}\n")
            sys.stdout.flush()
            if kept:
                kept.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return rows


def main() -> None:
    """Judge a sample; exits 1 where it refutes that the wanted share dies."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=100, help="how many mutants")
    parser.add_argument("--seed", type=int, default=0, help="which ones")
    parser.add_argument("--reach", choices=("package", "all"), default="all", help="tests that run")
    parser.add_argument("--keep", type=Path, help="file of the results, to go on from")
    options = parser.parse_args()
    rows = judge(options.sample, options.seed, options.reach, options.keep)
    died = sum(not row["survives"] for row in rows)
    low, high = exact_interval(died, len(rows))
    sys.stdout.write(f"{died} of {len(rows)} died: {100 * low:.0f} to {100 * high:.0f} %\n")
    sys.exit(high < LEAST)


if __name__ == "__main__":
    main()
