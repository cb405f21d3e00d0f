"""Digests of all that a judged row depends on, except seed and engine versions.

A row describes the present software only as long as these digests are those of the present code and
documents. Comments and docstrings do not count.
"""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import cbdsl
from cbdsl.api.documents import digest_of_text
from cbdsl.api.shipped import shipped_folder
from cbdsl_reproduction.judges.judge import Judge, JudgedCondition
from cbdsl_reproduction.trial_digest import trial_digest

# Packages of the control law, and of sensing.
_LAW = ("control", "kinematics")
_PERCEPTION = ("sensing", "runtime")
_WORLD = ("backends/cameras", "backends/staging")
# Judges of several programs share these modules.
_SHARED = ("claim_judges", "judge", "watch")
# Hexadecimal digits of a digest in a file.
_LENGTH = 16


def row_digests(judge: Judge, condition: JudgedCondition, engine: str) -> Mapping[str, str]:
    """Return the digests of law, perception, world, judge, and documents of a condition.

    Args:
        judge: Judge of the condition.
        condition: Condition with its program, stage and values.
        engine: Name of the backend.
    """
    return {
        "law": _code(_LAW),
        "perception": _code(_PERCEPTION),
        "world": _world(engine, driven=judge.is_real_time),
        "judge": _judge(judge.name, judge.folder),
        "documents": _documents(
            condition.program, tuple(condition.values.items()), condition.stage, judge.knowledge
        ),
    }


def code_text(source: str) -> str:
    """Return Python code without comments, docstrings, blank lines and indentation of lines."""
    lines = [line.encode() for line in source.splitlines()]
    for first, start, last, end in _ignored(source):
        for row in range(first - 1, last):
            left = start if row == first - 1 else 0
            right = end if row == last - 1 else len(lines[row])
            lines[row] = lines[row][:left] + b" " * (right - left) + lines[row][right:]
    return "\n".join(line.decode().strip() for line in lines if line.strip())


def _ignored(source: str) -> Iterator[tuple[int, int, int, int]]:
    """Yield first line, first byte, last line and last byte of each docstring and comment."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            body = node.body[0] if node.body else None
            if isinstance(body, ast.Expr) and ast.get_docstring(node, clean=False) is not None:
                # Parsed code has both ends, which the types of the module allow to lack.
                last, end = body.end_lineno or body.lineno, body.end_col_offset or 0
                yield body.lineno, body.col_offset, last, end
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            before = len(token.line[: token.start[1]].encode())
            line = token.start[0]
            yield line, before, line, before + len(token.string.encode())


@cache
def _code(packages: tuple[str, ...]) -> str:
    """Return the digest of the code of some packages of cbdsl."""
    root = Path(cbdsl.__file__).parent
    return _files(file for package in packages for file in (root / package).rglob("*.py"))


@cache
def _world(engine: str, *, driven: bool) -> str:
    """Return the digest of a simulated world, and of the drivers of a robot that is served."""
    packages = _code((*_WORLD, f"backends/{engine}", *(["robot"] if driven else [])))
    drivers = ["cbdsl_drive", "cbdsl_ros2"] if driven else []
    specs = [spec for name in (f"cbdsl_{engine}", *drivers) if (spec := find_spec(name))]
    folders = [Path(each) for spec in specs for each in spec.submodule_search_locations or ()]
    if not folders:
        return packages
    others = _files(file for folder in folders for file in folder.rglob("*.py"))
    return digest_of_text(packages + others)[:_LENGTH]


@cache
def _judge(name: str, own: str | None) -> str:
    """Return the digest of the module of a judge, with its aims, and of shared modules."""
    folder = Path(__file__).parent
    files = [folder / f"{module}.py" for module in (name, *_SHARED)]
    if own is None:
        return _files(file for file in files if file.is_file())
    further = folder.parent / own
    documents = [file.read_text("utf-8") for file in sorted(further.rglob("*.yaml"))]
    code = _files(file for file in (*files, *further.rglob("*.py")) if file.is_file())
    return digest_of_text("\n".join((code, *documents)))[:_LENGTH]


def _files(files: Iterable[Path]) -> str:
    texts = [f"{file.name}\n{code_text(file.read_text('utf-8'))}" for file in sorted(files)]
    return digest_of_text("\n".join(texts))[:_LENGTH]


@cache
def _documents(
    program: str, values: tuple[tuple[str, str], ...], stage: str | None, knowledge: tuple[str, ...]
) -> str:
    """Return the digest of a program with its dependencies, and of more knowledge."""
    parts = [trial_digest(program, dict(values), stage)] if program else []
    folder = shipped_folder() / "knowledge"
    parts += [(folder / name).read_text("utf-8") for name in knowledge]
    return digest_of_text("\n".join(parts))[:_LENGTH]
