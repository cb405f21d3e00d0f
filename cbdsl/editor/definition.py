"""Definition of the name under the cursor."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.lines import lines_of
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import document_named, section
from cbdsl.editor.cursor import Cursor
from cbdsl.editor.shared_names import named_at, shared_file

_SECTIONS = ("controllers", "use", "conditions")


class Definition(NamedTuple):
    """Line of a file.

    Attributes:
        file: Path of the file.
        line: Line, from 0.
    """

    file: Path
    line: int


def definition(buffers: Buffers, path: Path, cursor: Cursor) -> Definition | None:
    """Return the place that defines a controller, program, parameter, role or document."""
    lines = lines_of(buffers.text(path))
    if cursor.word.startswith("$"):
        declared = section(lines, "roles") | section(lines, "parameters")
        line = declared.get(cursor.word[1:])
        return None if line is None else Definition(path, line)
    file = document_named(buffers, path, cursor.key, cursor.word)
    if file is not None and not cursor.on_key:
        return Definition(file, 0)
    named = named_at(buffers, path, lines, cursor)
    if named is not None:
        return Definition(named.file, named.line)
    for name in _SECTIONS:
        line = section(lines, name).get(cursor.word)
        if line is not None:
            return Definition(path, line)
    shared = shared_file(buffers, path, lines, cursor.word)
    return None if shared is None else Definition(shared, 0)
