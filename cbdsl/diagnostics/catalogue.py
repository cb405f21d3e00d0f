"""Table of all codes, read by messages, ``cb explain`` and the tests."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from cbdsl.diagnostics.diagnostic import Severity
from cbdsl.diagnostics.entry import Entry
from cbdsl.diagnostics.examples import example

_FOLDER = Path(__file__).with_name("codes")

# Programs nested too deeply: "$step" in a path is each of these in turn, "$next" the one after.
_STEPS = range(1, 70)


@cache
def catalogue() -> dict[str, Entry]:
    """Return all entries by code."""
    names = sorted(file.stem for file in _FOLDER.glob("*.toml"))
    return {code: entry for name in names for code, entry in _table(name).items()}


def hundred(code: str) -> dict[str, Entry]:
    """Return the entries of the table that a code belongs to; read no other table."""
    # `CB504` is in `CB5.toml`. A message needs one table, and not all of them.
    return _table(code[:3])


@cache
def _table(name: str) -> dict[str, Entry]:
    file = _FOLDER / f"{name}.toml"
    if not file.is_file():
        return {}
    fields = tomllib.loads(file.read_text(encoding="utf-8"))
    return {code: _entry(code, **row) for code, row in fields.items()}


def _entry(
    code: str,
    *,
    good: dict[str, str],
    bad: dict[str, str] | None = None,
    path: str = "programs/example.yaml",
    beside: dict[str, dict[str, str]] | None = None,
    severity: str = "error",
    **texts: Any,
) -> Entry:
    return Entry(
        code,
        **texts,
        bad=None if bad is None else _bad(path, bad),
        path=path,
        beside=dict(_beside(beside or {})),
        severity=Severity(severity),
        good=example(path, good, _FOLDER),
    )


def _bad(path: str, spelling: dict[str, str]) -> str | bytes:
    """Return the text of a bad example, or its bytes if it is not UTF-8."""
    if "latin_1" in spelling:
        return spelling["latin_1"].encode("latin-1")
    return example(path, spelling, _FOLDER)


def _beside(files: dict[str, dict[str, str]]) -> Iterator[tuple[str, str]]:
    for pattern, spelling in files.items():
        for step in _STEPS if "$step" in pattern else (0,):
            path = pattern.replace("$step", str(step))
            text = example(path, spelling, _FOLDER)
            yield path, text.replace("$next", str(step + 1))
