"""Keys on the wrong level, which are one diagnostic and are read at their proper place."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cbdsl.documents.document import Document
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import shipped
from cbdsl.yaml_text.reader import read_document, read_sound_parts

FILES = [
    path
    for folder in ("robots", "programs")
    for path in sorted((shipped() / folder).rglob("*.yaml"))
]
PLAIN: dict[Path, Any] = {
    file: compose(file.read_text("utf-8"), str(file)).root.plain() for file in FILES
}
SECTIONS = ("form", "tip", "quiescence", "standoff", "funnel", "limits", "control", "density")


def mappings(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of all mappings in a value that are entries of another mapping."""
    for step, inner in value.items() if isinstance(value, dict) else enumerate(value):
        if isinstance(inner, dict) and isinstance(value, dict):
            yield (*path, step)
        if isinstance(inner, (dict, list)):
            yield from mappings(inner, (*path, step))


CASES = [(f, p) for f, data in PLAIN.items() for p in mappings(data) if p[-1] in SECTIONS]


def without_level(value: Any, path: tuple[Any, ...], *, keep: bool) -> Any:
    """Return a value whose mapping at a path is merged into its parent, with or without its key."""
    step, *rest = path
    if rest:
        changed = {step: without_level(value[step], tuple(rest), keep=keep)}
        return {**value, **changed} if isinstance(value, dict) else value
    flat: dict[str, Any] = {}
    for key, inner in value.items():
        if key == step:
            flat.update({**({key: None} if keep else {}), **inner})
        else:
            flat[key] = inner
    return flat


def is_possible(file: Path, path: tuple[Any, ...]) -> bool:
    """Return whether the merged keys would be unique."""
    outer = PLAIN[file]
    for step in path[:-1]:
        outer = outer[step]
    return isinstance(outer, dict) and not outer.keys() & outer[path[-1]].keys()


# Shared controllers are read as they are called: the check finds theirs.
POSSIBLE = [
    (file, path)
    for file, path in CASES
    if is_possible(file, path)
    and all(isinstance(step, str) for step in path)
    and file.parent.name != "shared"
]


@pytest.mark.parametrize("keep", [True, False], ids=["indented_too_little", "key_left_out"])
def test_flat_section_is_one_finding_and_is_read(keep: bool) -> None:
    for file, path in POSSIBLE[:: len(POSSIBLE) // 25]:
        if path[-1] == "standoff" and not keep:
            continue
        data = without_level(PLAIN[file], path, keep=keep)
        loaded = read_sound_parts(file, Document, json.dumps(data))
        assert [fault.code for fault in loaded.diagnostics] == ["CB209"], (file, path)
        assert loaded.document == read_document(file).document


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_another_kind_is_one_finding_and_the_rest_is_read(file: Path) -> None:
    other = "model" if PLAIN[file]["kind"] != "model" else "robot"
    loaded = read_sound_parts(file, Document, json.dumps({**PLAIN[file], "kind": other}))
    assert [fault.code for fault in loaded.diagnostics] == ["CB210"]
    assert loaded.document == read_document(file).document


@pytest.mark.parametrize("section", ["actions", "limits"])
def test_misplaced_section_is_read_at_its_proper_place(section: str) -> None:
    file = shipped() / "programs" / "reach.yaml"
    data = {key: value for key, value in PLAIN[file].items() if key != section}
    data["controllers"] = {**data["controllers"], section: PLAIN[file][section]}
    loaded = read_sound_parts(file, Document, json.dumps(data))
    assert [fault.code for fault in loaded.diagnostics] == ["CB209"]
    assert loaded.document == read_document(file).document
