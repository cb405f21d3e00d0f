"""Table of all codes, read by messages, ``cb explain`` and the tests."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

from cbdsl.diagnostics.diagnostic import Severity
from cbdsl.diagnostics.entry import Entry

_HEAD = "cbdsl: 1\nkind: {}\nname: $name\n"
_DEXTER = _HEAD.format("program") + "robot: dexter\ncontrollers:\n  track: "
_TRACK = (
    "{potential: spring, reference: [0 rad, 0 rad], feedback: cyclopean.motion, effector: head}"
)
_ROBOT = _HEAD.format("robot") + "model: example.urdf\nbase: base\neffectors:\n"
_CONTROL = "control: {rate: 120 Hz, tasks: {}}\n"
_BALL = "things:\n  ball: {form: {shape: ball, radius: 4 cm}, mass: 100 g}\n"

_SCHEMA = (
    _HEAD.format("schema") + "program: reachtouch\npolicy: reachtouch\n"
    "features: {place: stereo.sat_10, number: count.sat_10}\nallocations:\n"
    "  right: {arm: right_arm, hand: right_hand}\n  left: {arm: left_arm, hand: left_hand}\n"
)

_CATALOG = _HEAD.format("catalog") + "robot: dexter\nfeature: red\n"
_RELATIONS = _HEAD.format("relations") + "robot: dexter\nprogram: impedance\n"
_META_CATALOG = _HEAD.format("meta_catalog") + "robot: dexter\n"

#: Frames of examples: ``$name`` is the file's name, ``$body`` the text of the catalogue.
_FRAMES = {
    "program": f"{_HEAD.format('program')}$body\n",
    "robot": f"{_HEAD.format('robot')}$body\n",
    "stage": f"{_HEAD.format('stage')}$body\n",
    "policy": f"{_HEAD.format('policy')}$body\n",
    "calibration": f"{_HEAD.format('calibration')}$body\n",
    "model": f"{_HEAD.format('model')}$body\n",
    "schema": f"{_SCHEMA}$body\n",
    "catalog": f"{_CATALOG}$body\n",
    "shared": f"{_HEAD.format('shared')}robot: dexter\n$body\n",
    "relations": f"{_RELATIONS}$body\n",
    "meta_catalog": f"{_META_CATALOG}$body\n",
    "afforded": _SCHEMA.replace("features: {", "catalog: ball\nfeatures: {sure: $body, ")
    + "choose: {if: sure > 0.5, then: left, else: right}\notherwise: [right]\n",
    "tracking": f"{_DEXTER}{_TRACK}\n$body\n",
    "controller": f"{_DEXTER}{{$body}}\nactions: [track]\n",
    "effectors": f"{_ROBOT}$body\n{_CONTROL}",
    "pan": f"{_ROBOT}  head: {{joints: [pan]}}\n{_CONTROL}$body\n",
    "ball": f"{_HEAD.format('stage')}robot: dexter\n{_BALL}contexts:\n$body\n",
    "text": "$body\n",
}


def example(path: str, spelling: dict[str, str], folder: Path) -> str:
    """Return the text of an example.

    Args:
        path: Path of its file, which names the document.
        spelling: Body by the name of a frame; for ``file``, the name of a file in the folder.
        folder: Folder of the catalogue's tables.
    """
    ((frame, body),) = spelling.items()
    if frame == "file":
        return (folder / body).read_text(encoding="utf-8")
    name = PurePosixPath(path).stem
    return _FRAMES[frame].replace("$name", name).replace("$body", body)


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
