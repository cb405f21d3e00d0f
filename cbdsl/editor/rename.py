"""Renaming: the places of a name in all documents that contain it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.lines import lines_of
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.documents.kinds import KINDS
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import document_named, is_composed, section
from cbdsl.editor.cursor import Cursor, cursor
from cbdsl.editor.shared_names import named_at, offered, shared_spots, taken_up

# Sections of policies that name their program's controllers.
_LEARNED = ("predicates", "policy", "values", "transitions")
_MEMBERS = ("controllers", "use")


class Occurrence(NamedTuple):
    """Span of a line.

    Attributes:
        line: Line, from 0.
        start, end: Columns, from 0, ``end`` exclusive.
    """

    line: int
    start: int
    end: int


class Renaming(NamedTuple):
    """All changes of a new name.

    Attributes:
        old: Name that is replaced, without its dollar sign.
        spots: Places of the name, by file.
        moved: File with the name of its document, if that document is renamed.
        taken: Names of the same kind that exist already.
    """

    old: str
    spots: dict[Path, list[Occurrence]]
    moved: Path | None = None
    taken: frozenset[str] = frozenset()


def is_name(text: str) -> bool:
    """Return whether a text can be the name of a controller, a parameter or a document."""
    return re.fullmatch(NAME_PATTERN, text) is not None


def renaming(buffers: Buffers, path: Path, at: Cursor) -> Renaming | None:
    """Return the places of the name under the cursor, or ``None`` if it cannot be renamed.

    Parameters are renamed in one program. Controllers and used programs are also renamed in its
    policies. Documents are renamed in all documents in the folder of the editor.
    """
    lines = lines_of(buffers.text(path))
    is_parameter = at.on_key and at.steps == ("parameters",)
    is_role = at.steps[:1] == ("roles",) and _top(lines, "kind") == "program"
    if at.word.startswith("$") or is_parameter or is_role:
        return _of_parameter(path, lines, at.word.removeprefix("$"))
    is_own_name = at.steps == ("name",) and not at.on_key
    file = path if is_own_name else None if at.on_key else document_named(
        buffers, path, at.key, at.word
    )  # fmt: skip
    if file is not None:
        kind = _top(lines, "kind") if is_own_name else at.key
        return _of_document(buffers, file.absolute(), kind, at.word)
    shared = _shared_file(buffers, path, lines, at)
    if shared is not None:
        return _of_shared(buffers, shared.absolute(), at.word)
    if any(at.word in section(lines, name) for name in _MEMBERS) and _names_member(lines, at):
        return _of_member(buffers, path, lines, at.word)
    return None


def _of_parameter(path: Path, lines: Sequence[str], name: str) -> Renaming | None:
    roles = section(lines, "roles")
    declared = roles | section(lines, "parameters")
    if name not in declared:
        return None
    spots = [
        Occurrence(number, match.start() + 1, match.end())
        for number, line in enumerate(lines)
        for match in re.finditer(rf"\$\b{re.escape(name)}\b", _code(line))
    ]
    # Relations of other roles name a role without a dollar sign.
    spots += [
        Occurrence(number, *match.span("name"))
        for number in sorted(set(roles.values()))
        for match in re.finditer(
            rf"(?:\b(?:on|than)\s|:)\s*(?P<name>{re.escape(name)})\b", _code(lines[number])
        )
    ]
    key = re.search(rf"\b{re.escape(name)}(?=[\"']?\s*:)", lines[declared[name]])
    assert key is not None, "its section has it as a key"
    spots.append(Occurrence(declared[name], key.start(), key.end()))
    return Renaming(name, {path: sorted(spots)}, taken=frozenset(declared))


def _of_member(buffers: Buffers, path: Path, lines: Sequence[str], name: str) -> Renaming:
    spots = {path: list(_member_spots(lines, name))}
    program = _top(lines, "name")
    for file in buffers.documents():
        others = lines_of(buffers.text(file))
        if _top(others, "kind") == "policy" and _top(others, "program") == program:
            spots[file] = list(_member_spots(others, name))
    members = frozenset(each for key in _MEMBERS for each in section(lines, key))
    return Renaming(name, {file: each for file, each in spots.items() if each}, taken=members)


def _shared_file(buffers: Buffers, path: Path, lines: Sequence[str], at: Cursor) -> Path | None:
    """Return the shared document that declares the name under the cursor."""
    if _top(lines, "kind") != "shared":
        named = named_at(buffers, path, lines, at)
        return None if named is None else named.file
    is_key = at.on_key and at.steps in (("controllers",), ("conditions",))
    is_named = is_key or (not at.on_key and is_composed(at.steps))
    known = section(lines, "controllers") | section(lines, "conditions")
    return path if is_named and at.word in known else None


def _of_shared(buffers: Buffers, file: Path, name: str) -> Renaming | None:
    # Shipped documents belong to others.
    if not file.is_relative_to(buffers.here):
        return None
    spots = {}
    for each in {file, *buffers.documents()}:
        lines = lines_of(buffers.text(each))
        taken = taken_up(buffers, each, lines).get(name)
        if each == file or (taken is not None and taken.file.absolute() == file):
            own = (name in section(lines, key) for key in (*_MEMBERS, "conditions"))
            places = shared_spots(lines, name, each != file and any(own))
            spots[each] = [Occurrence(*spot) for spot in places]
    known = frozenset(each.name for each in offered(buffers, file))
    return Renaming(name, {each: places for each, places in spots.items() if places}, taken=known)


def _member_spots(lines: Sequence[str], name: str) -> Iterator[Occurrence]:
    # Dots and dollar signs are parts of names: `head` is not within `head.position` or `$head`.
    pattern = re.compile(rf"(?<![\w.$]){re.escape(name)}(?![\w.])")
    for number, line in enumerate(lines):
        for match in pattern.finditer(_code(line)):
            if _names_member(lines, cursor(lines, number, match.start())):
                yield Occurrence(number, match.start(), match.end())


def _names_member(lines: Sequence[str], at: Cursor) -> bool:
    """Return whether a word at a place is the name of a controller or of a used program."""
    if not at.steps:
        return False
    if _top(lines, "kind") == "policy":
        return at.steps[0] in _LEARNED or at.steps == ("provenance", "actions")
    if at.on_key and at.steps[0] in _MEMBERS:
        return len(at.steps) == 1
    return at.steps[0] not in _MEMBERS[1:] and is_composed(at.steps)


def _of_document(buffers: Buffers, file: Path, kind: str, name: str) -> Renaming | None:
    # Documents outside of the editor's folder, such as shipped ones, belong to others.
    if kind not in KINDS.builtins or not file.is_relative_to(buffers.here):
        return None
    own = re.compile(rf"^name:\s*[\"']?(?P<name>{re.escape(name)})[\"']?\s*$")
    named = re.compile(rf"(?<![\w.]){kind}:\s*[\"']?(?P<name>{re.escape(name)})(?![\w.])")
    spots: dict[Path, list[Occurrence]] = {}
    for each in {file, *buffers.documents()}:
        for number, line in enumerate(lines_of(buffers.text(each))):
            patterns = (own, named) if each == file else (named,)
            for match in (m for pattern in patterns for m in pattern.finditer(_code(line))):
                spots.setdefault(each, []).append(Occurrence(number, *match.span("name")))
    texts = {each: lines_of(buffers.text(each)) for each in buffers.documents()}
    taken = {_top(lines, "name") for lines in texts.values() if _top(lines, "kind") == kind}
    return Renaming(name, spots, file if file.stem == name else None, frozenset(taken))


def _top(lines: Sequence[str], key: str) -> str:
    """Return the value of a key at the top level, as far as it is a name."""
    pattern = re.compile(rf"{key}:\s*[\"']?([\w-]+)")
    return next((match[1] for line in lines if (match := pattern.match(line))), "")


def _code(line: str) -> str:
    """Return a line without its comment."""
    return re.split(r"(?:^|\s)#", line, maxsplit=1)[0]
