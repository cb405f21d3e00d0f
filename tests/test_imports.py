"""Imports lead somewhere, in each module and in tests, which no type checker reads."""

from __future__ import annotations

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tests.conftest import ROOT

#: Folders with Python files, and the folder from which their packages are imported.
FOLDERS = ("tests", "benchmarks", "distributions", "reproduction")
PLUGINS = {folder.name.replace("-", "_"): folder for folder in (ROOT / "distributions").glob("*-*")}
SOURCES = {
    "cbdsl": ROOT, "tests": ROOT, "cbdsl_reproduction": ROOT / "reproduction", **PLUGINS,
}  # fmt: skip
#: Programs of environments of their own.
ELSEWHERE = {
    "cbdsl_reproduction.judges.fast_dds_bridge",
    "cbdsl_reproduction.worlds.robosuite_worker",
}
FILES = [file for folder in FOLDERS for file in sorted((ROOT / folder).rglob("*.py"))]


def _file_of(module: str) -> Path | None:
    """Return the file of a module of this project; ``None`` if there is none."""
    path = SOURCES[module.split(".")[0]].joinpath(*module.split("."))
    if path.with_suffix(".py").is_file():
        return path.with_suffix(".py")
    return path / "__init__.py" if path.is_dir() else None


@cache
def _bound(file: Path) -> frozenset[str]:
    """Return the names that a module binds anywhere, and ``*`` if it computes names."""
    if not file.is_file():
        return frozenset()
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        match node:
            case ast.FunctionDef(name="__getattr__"):
                found.add("*")
            case ast.FunctionDef() | ast.ClassDef():
                found.add(node.name)
            case ast.Import() | ast.ImportFrom():
                found.update((each.asname or each.name).split(".")[0] for each in node.names)
            case ast.Name(ctx=ast.Store()):
                found.add(node.id)
    return frozenset(found)


def missing(text: str) -> Iterator[str]:
    """Yield the imports of a text from this project that lead nowhere."""
    for node in ast.walk(ast.parse(text)):
        modules: list[tuple[str, str]] = []
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            modules = [(node.module, each.name) for each in node.names]
        elif isinstance(node, ast.Import):
            modules = [(each.name, "") for each in node.names]
        for module, name in modules:
            if module.split(".")[0] not in SOURCES:
                continue
            file = _file_of(module)
            if file is None:
                yield module
            elif name and not ({name, "*"} & _bound(file) or _file_of(f"{module}.{name}")):
                yield f"{module}.{name}"


def test_imports_of_files_outside_of_the_package_exist() -> None:
    found = {
        f"{file.relative_to(ROOT)}: {name}"
        for file in FILES
        for name in missing(file.read_text("utf-8"))
    }
    assert found == set()


@pytest.mark.parametrize(
    "text",
    [
        "from cbdsl_ros2 import server",
        "from cbdsl_ros2.server import RobotServer",
        "def warm():\n    import cbdsl.control.laws",
    ],
)
def test_import_of_a_renamed_module_is_found(text: str) -> None:
    assert len(list(missing(text))) == 1


@pytest.mark.parametrize("package", ["cbdsl", "cbdsl_reproduction", *sorted(PLUGINS)])
def test_modules_of_a_package_import_on_this_python(package: str) -> None:
    folder = SOURCES[package] / package
    modules = [each.name for each in pkgutil.walk_packages([str(folder)], f"{package}.")]
    assert modules
    for module in modules:
        if module in ELSEWHERE or module.endswith(".__main__"):
            continue
        importlib.import_module(module)
