"""Controllers and conditions that a document takes up from shared documents, read as text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.lines import lines_of
from cbdsl.documents.shared import SharedDocument
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import Completion, is_composed, section
from cbdsl.editor.cursor import Cursor

_SECTIONS = ("controllers", "conditions")


class SharedName(NamedTuple):
    """Declaration in a shared document.

    Attributes:
        file: File of the document.
        line: Line of the declaration, from 0.
        signature: Name with its parameters.
    """

    file: Path
    line: int
    signature: str

    @property
    def name(self) -> str:
        """Name alone."""
        return self.signature.partition("(")[0]


def shared_file(buffers: Buffers, path: Path, lines: Sequence[str], name: str) -> Path | None:
    """Return the file of a shared document that a program names in its section ``shared``."""
    named = section(lines, "shared")
    return buffers.library.find(SharedDocument, name, path) if name in named else None


def offered(buffers: Buffers, file: Path) -> Iterator[SharedName]:
    """Yield the declarations of a shared document."""
    lines = lines_of(buffers.text(file))
    for key in _SECTIONS:
        for name, line in section(lines, key).items():
            match = re.search(rf"\b{name}(\([\w, ]*\))?", lines[line])
            yield SharedName(file, line, match[0] if match else name)


def taken_up(buffers: Buffers, path: Path, lines: Sequence[str]) -> dict[str, SharedName]:
    """Return the declarations that a program takes up, by name."""
    text = "\n".join(lines)
    listed = re.search(r"^shared:(.*(?:\n[ \t].*)*)", text, re.MULTILINE)
    words = set(re.findall(r"\w+", listed[1])) if listed else set()
    files = (shared_file(buffers, path, lines, name) for name in section(lines, "shared"))
    every = (each for file in files if file is not None for each in offered(buffers, file))
    return {each.name: each for each in every if each.name in words}


def named_at(buffers: Buffers, path: Path, lines: Sequence[str], at: Cursor) -> SharedName | None:
    """Return the declaration that the word under a cursor calls or lists, if it is a shared one."""
    named = taken_up(buffers, path, lines).get(at.word)
    # In `hold: hold($hand, 6 N)`, the key is a controller of the program; the call is a shared one.
    is_call = not at.on_key and at.key == at.word
    if named is None or is_call or at.steps[:1] == ("shared",):
        return named
    own = section(lines, "controllers") | section(lines, "conditions") | section(lines, "use")
    return None if at.word in own else named


def shared_choices(buffers: Buffers, path: Path, steps: Sequence[str]) -> list[Completion]:
    """Return the shared names that a value, or a list of names to take up, may have."""
    lines = lines_of(buffers.text(path))
    if steps[:1] == ("shared",):
        if len(steps) == 1:
            names = buffers.library.names(SharedDocument, path)
            return [Completion(name, "shared controllers") for name in names]
        file = buffers.library.find(SharedDocument, steps[1], path)
        known = () if file is None else offered(buffers, file)
        return [Completion(each.name, each.signature) for each in known]
    if not is_composed(steps):
        return []
    named = taken_up(buffers, path, lines).values()
    return [Completion(each.signature, f"shared: {each.file.stem}") for each in named]


def shared_spots(lines: Sequence[str], name: str, is_own: bool) -> Iterator[tuple[int, int, int]]:
    """Yield line, start and end of each place that lists or calls a shared name.

    Args:
        lines: Lines of a program, or of the shared document itself.
        name: Shared name.
        is_own: True if the document has an entry of this name, so that only calls mean it.
    """
    inside, declared = "", set[int]()
    if not is_own:
        declared = {
            line for key in _SECTIONS for each, line in section(lines, key).items() if each == name
        }
    for number, line in enumerate(lines):
        match = re.match(r"(\w+)\s*:", line)
        inside = match[1] if match else inside
        code = re.split(r"(?:^|\s)#", line, maxsplit=1)[0]
        end = r"(?=\()" if is_own and inside != "shared" else r"(?![\w.])"
        for match in re.finditer(rf"(?<![\w.$]){re.escape(name)}{end}", code):
            # A key of a section, such as the field `hold:` of a triple, is no name.
            is_key = re.match(r"\s*:", code[match.end() :]) is not None
            if inside in ("name", "description", "parameters"):
                continue
            if not is_key or number in declared:
                yield number, *match.span()
