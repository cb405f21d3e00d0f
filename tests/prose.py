"""Measure of prose: four numbers per file, with the places that they count.

For Python, docstrings and comments are measured; for Markdown, text outside of code. The measures
are

- descriptions of parameters that are fragments (``of the robot``),
- headless relative clauses (``what moves``),
- sentences of more than 25 words,
- Markdown lines of more than 120 characters outside of tables.

``python -m tests.prose`` lowers the limits in ``tests/prose_limits.toml`` to the present
numbers, and never raises one.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
LIMITS = ROOT / "tests" / "prose_limits.toml"
#: Largest numbers of a sentence's words, and of a line's characters.
WORDS, CHARACTERS = 25, 120

_HEADLESS = re.compile(
    r"\b(what|whatever|whoever|whichever|wherever|that which|those that|those which|the ones? that"
    r"|nobody|somebody|anybody|told|tells?)\b",
    re.IGNORECASE,
)
_FRAGMENT = re.compile(
    r"(of|for|in|at|on|by|from|with|how|where|who|whose|which|as of|as in|see|that|is|are|has|have"
    r"|may|takes?|gives?|says?|makes?|holds?|must|its|their|to which|than|before"
    r"|after|beside|among)\b",
    re.IGNORECASE,
)
_SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Yields):")
_ENTRY = re.compile(r" {4}\*{0,2}[A-Za-z_][\w., ]*: +(\S.*)")
_CODE = re.compile(r"``[^`]*``|`[^`]*`|<!--.*?-->|\]\([^)]*\)")
_GENERATED = re.compile(r"docs/reproduction/\w+\.md")


class Place(NamedTuple):
    """Place that a measure counts: name of the measure, line, and text."""

    measure: str
    line: int
    text: str


def files() -> list[str]:
    """Return the measured files, relative to the root."""
    folders = ("cbdsl", "distributions", "reproduction", "tests", "benchmarks", "docs", "robots")
    found = [path for name in folders for path in (ROOT / name).rglob("*.*")]
    found += ROOT.glob("*.md")
    names = (
        path.relative_to(ROOT).as_posix()
        for path in found
        if path.suffix in (".py", ".md") and not {"vendor", "schemas"} & {*path.parts}
    )
    return sorted(name for name in names if not _GENERATED.fullmatch(name))


def places(name: str, text: str) -> list[Place]:
    """Return all places in a file that count."""
    return [*(_python(text) if name.endswith(".py") else _markdown(text))]


def excess(counts: Mapping[str, int], limits: Mapping[str, int]) -> list[str]:
    """Return the measures of a file that exceed their limits."""
    return [measure for measure, number in counts.items() if number > limits.get(measure, 0)]


def _python(source: str) -> Iterator[Place]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield from _docstring(text, node.body[0].lineno)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield from _headless(token.string, token.start[0])


def _docstring(text: str, line: int) -> Iterator[Place]:
    prose, section = [], False
    for row in text.splitlines():
        section = section or bool(_SECTION.fullmatch(row))
        entry = _ENTRY.fullmatch(row)
        if section and entry:
            row = entry[1]
            if _FRAGMENT.match(row):
                yield Place("fragment", line, row)
        elif not section:
            prose.append(row)
        yield from _headless(row, line)
    yield from _long_sentences("\n".join(prose), line)


def _markdown(text: str) -> Iterator[Place]:
    fenced = False
    for line, row in enumerate(text.splitlines(), 1):
        if row.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced and not row.startswith("    "):
            is_table = row.lstrip().startswith("|")
            if len(row) > CHARACTERS and not is_table:
                yield Place("long line", line, row)
            if not is_table:
                yield from _long_sentences(row, line)
            yield from _headless(row, line)


def _headless(text: str, line: int) -> Iterator[Place]:
    for match in _HEADLESS.finditer(_CODE.sub("x", text)):
        yield Place("headless clause", line, f"'{match[0]}' in: {text.strip()}")


def _long_sentences(text: str, line: int) -> Iterator[Place]:
    """Yield sentences with too many words; indented rows are code or tables."""
    rows = ("" if row.startswith("  ") or "``  " in row else row for row in text.splitlines())
    for paragraph in re.split(r"\n\s*\n|\n(?=[-*] )", "\n".join(rows)):
        for sentence in re.split(r"(?<=[.!?:;])\s+", _CODE.sub("x", paragraph)):
            number = len(re.findall(r"[A-Za-z']+", sentence))
            if number > WORDS:
                yield Place("long sentence", line, f"{number} words: {' '.join(sentence.split())}")


def read_limits() -> dict[str, dict[str, int]]:
    """Return the limits that differ from 0, by file and measure."""
    return tomllib.loads(LIMITS.read_text("utf-8")) if LIMITS.exists() else {}


def _lowered() -> Iterator[str]:
    """Yield the lines of the limits, none above its present value."""
    old, is_first = read_limits(), not LIMITS.exists()
    for name in files():
        counts = Counter(place.measure for place in places(name, (ROOT / name).read_text("utf-8")))
        limits = {
            measure: number if is_first else min(number, old.get(name, {}).get(measure, 0))
            for measure, number in sorted(counts.items())
        }
        pairs = ", ".join(f'"{measure}" = {number}' for measure, number in limits.items() if number)
        if pairs:
            yield f'"{name}" = {{{pairs}}}\n'


if __name__ == "__main__":
    text = "# Numbers of prose that may only fall; `python -m tests.prose` lowers them.\n"
    LIMITS.write_text(text + "".join(_lowered()), "utf-8")
