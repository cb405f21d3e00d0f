"""Catalogue entries as text, and the catalogue as a page of documentation."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from difflib import unified_diff

from cbdsl.diagnostics.entry import Entry
from cbdsl.diagnostics.legible_text import legible
from cbdsl.diagnostics.published import page_of

_HEAD = """\
# Diagnostics

Diagnostics of `cb validate`, by code. `cb explain CODE` prints the same in a terminal.
Each example is a whole document. Without the lines marked `+` it has the diagnostic.
Without the lines marked `-` it has none.
"""


def explanation(entry: Entry) -> str:
    """Return the explanation of a diagnostic for a terminal."""
    parts = [f"{entry.code}: {entry.title}", textwrap.fill(entry.explanation, 88)]
    example = "\n".join(_difference(entry))
    if example:
        parts.append(f"For example, {entry.path}, with (-) and without (+) it:")
        parts.append(textwrap.indent(example, "    "))
    if page := page_of(entry.code):
        parts.append(page)
    return "\n\n".join(parts)


def page(entries: Iterable[Entry]) -> str:
    """Return a page of Markdown with a section for each entry."""
    return f"{_HEAD}\n{sections(entries)}"


def sections(entries: Iterable[Entry]) -> str:
    """Return the sections of such a page."""
    return "\n".join(map(_section, entries)).rstrip("\n")


def _section(entry: Entry) -> str:
    kind = "" if entry.severity.value == "error" else f" ({entry.severity.value})"
    example = "\n".join(_difference(entry))
    block = f"\n```diff\n{example}\n```\n" if example else ""
    return (
        f"## {entry.code}: {entry.title}{kind}\n\n{textwrap.fill(entry.explanation, 100)}\n{block}"
    )


def _difference(entry: Entry) -> Iterator[str]:
    """Yield the lines of both examples; none if the bad example has no file."""
    if entry.bad is None:
        return
    # As many lines of context as there are lines, so that each example is a whole document.
    bad, good = _shown(entry.bad), _shown(entry.good)
    lines = unified_diff(bad, good, lineterm="", n=len(bad) + len(good))
    for number, line in enumerate(lines):
        if number > 2:  # after the names of the two files and their line numbers
            yield line.rstrip() if line.startswith(" ") else line


def _shown(example: str | bytes) -> list[str]:
    """Return the lines of an example, with unprintable characters written as escapes."""
    text = example if isinstance(example, str) else example.decode("utf-8", "backslashreplace")
    return [legible(line) for line in text.splitlines()]
