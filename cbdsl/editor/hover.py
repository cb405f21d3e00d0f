"""Explanation of the word under the cursor, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from textwrap import dedent

from cbdsl.diagnostics.lines import lines_of
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import document_named, is_composed, robot_resources, section
from cbdsl.editor.cursor import Cursor
from cbdsl.editor.keys import keys
from cbdsl.editor.shared_names import named_at
from cbdsl.types.casts import CASTS
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import Resource

# Bound on the shown lines of a controller.
_MOST_LINES = 16


def hover(buffers: Buffers, path: Path, cursor: Cursor) -> str | None:
    """Return an explanation of a key, potential, resource, document or controller, or ``None``."""
    if cursor.on_key:
        description = keys(buffers.text(path), cursor.steps).get(cursor.word)
        return f"**{cursor.word}**: {description}" if description else None
    if cursor.key == "potential" and cursor.word in POTENTIALS:
        return _potential(POTENTIALS[cursor.word])
    resource = robot_resources(buffers, path).get(cursor.word)
    if resource is not None:
        return _resource(resource)
    file = document_named(buffers, path, cursor.key, cursor.word)
    if file is None:
        lines = lines_of(buffers.text(path))
        named = named_at(buffers, path, lines, cursor)
        if named is not None:
            return _declaration(lines_of(buffers.text(named.file)), named.line)
        return _controller(lines, cursor)
    loaded = buffers.document(file)
    description = getattr(loaded.document, "description", None) if loaded else None
    return f"**{cursor.word}**: {description or file}"


def _controller(lines: Sequence[str], cursor: Cursor) -> str | None:
    """Return the declaration of a composition's controller, cut to the bound on lines."""
    first = section(lines, "controllers").get(cursor.word)
    if first is None or not is_composed(cursor.steps):
        return None
    return _declaration(lines, first)


def _declaration(lines: Sequence[str], first: int) -> str:
    indent = len(lines[first]) - len(lines[first].lstrip())
    inner = takewhile(
        lambda line: not line.strip() or len(line) - len(line.lstrip()) > indent, lines[first + 1 :]
    )
    text = dedent("\n".join([lines[first], *inner][:_MOST_LINES])).strip()
    return f"```yaml\n{text}\n```"


def _potential(potential: PotentialType) -> str:
    return (
        f"**{potential.name}** {potential.symbol}, {potential.equation}; of "
        f"{', '.join(sorted(potential.accepts))}"
    )


def _resource(resource: Resource) -> str:
    """Return type, unit and origin of a resource, and the casts from its type."""
    lines = [
        f"**{resource.name}**: {resource.type}, {resource.type.unit}, "
        f"{resource.origin.value}{', can be moved' if resource.movable else ''}"
    ]
    name = resource.type.name
    lines += [
        f"- {cast.name}: to {cast.target} ({cast.equation})"
        for cast in CASTS
        if cast.source == name
    ]
    return "\n".join(lines)
