"""Layout of the package: folders that a reader can survey, and one module to a file name."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

from tests.conftest import ROOT

PACKAGE = ROOT / "cbdsl"
MOST_FILES = 25

#: Folders whose modules share the names of the same parts, with the reason.
MIRRORS = {
    "each engine implements the contract in these parts": (
        "backends",
        "backends/bullet",
        "backends/kinematic",
        "backends/staging",
    ),
    "one document kind: its model, its check, its compiled data, and its door for Python": (
        "documents",
        "checking",
        "checking/knowledge",
        "checking/robot",
        "checking/stage",
        "program",
        "api",
        "api/reading",
    ),
    "one verb: its command and its function": ("cli", "api"),
}
#: Further pairs, with the reason.
PAIRS = {
    "potential": "declared type and compiled function, which a plug-in defines together",
    "onset": "compiled condition, and the modifier that uses it",
    "policy": "document, its check, and the policy that decides by it",
    "schema": "the command has the name that users know; it writes JSON Schemas",
}


def _modules() -> dict[str, list[Path]]:
    """Return the files of the package by name, relative to it."""
    by_name = defaultdict(list)
    for file in sorted(PACKAGE.rglob("*.py")):
        if file.stem != "__init__":
            by_name[file.stem].append(file.relative_to(PACKAGE))
    return by_name


def _is_mirror(files: list[Path]) -> bool:
    """Return whether modules of one name are the same part of mirrored folders."""
    # `cb show policy` is cli/show/policy.py: a view is named by its word, a contract by its group.
    folders = {file.parent.as_posix() for file in files} - {"cli/show", "extend"}
    return len(folders) == 1 or any(folders.issubset(mirror) for mirror in MIRRORS.values())


def test_modules_of_one_name_mirror_each_other() -> None:
    doubled = {name: files for name, files in _modules().items() if len(files) > 1}
    unrelated = {n: [*map(str, f)] for n, f in doubled.items() if not _is_mirror(f)}
    assert unrelated.keys() - PAIRS.keys() == set(), unrelated


def test_justified_pairs_still_exist() -> None:
    modules = _modules()
    stale = [name for name in PAIRS if len(modules[name]) < 2 or _is_mirror(modules[name])]
    assert stale == []


def test_folder_has_at_most_25_modules() -> None:
    folders: dict[str, int] = defaultdict(int)
    for files in _modules().values():
        for file in files:
            folders[file.parent.as_posix()] += 1
    assert {name: count for name, count in folders.items() if count > MOST_FILES} == {}


def test_constants_of_a_module_are_assigned_once() -> None:
    twice = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        names = [
            target.id
            for node in ast.parse(file.read_text("utf-8")).body
            if isinstance(node, ast.Assign)
            for target in node.targets
            if isinstance(target, ast.Name)
        ]
        if len(names) > len(set(names)):
            twice[str(file.relative_to(PACKAGE))] = sorted({n for n in names if names.count(n) > 1})
    assert twice == {}, "code between the two reads the second value"
