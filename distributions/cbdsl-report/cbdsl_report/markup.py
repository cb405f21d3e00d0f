"""Parts of pages that are the same with and without a script: tables of text and numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape
from pathlib import Path

#: Templates, style sheets and scripts of these pages.
ASSETS = Path(__file__).parent / "assets"


class Markup(str):
    """Text that is HTML already."""


def html(value: object) -> str:
    """Return a value as HTML: text is escaped, markup is kept, ``None`` is an empty cell."""
    if value is None:
        return ""
    return value if isinstance(value, Markup) else escape(str(value))


def table(
    caption: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[object]],
    words: Collection[int] = (0,),
) -> Markup:
    """Return a table in a box that scrolls if it is too wide; keys scroll it, too.

    Args:
        caption: Caption of the table.
        headings: Headings of the columns.
        rows: Cells of the rows; the first of each is the row's own heading.
        words: Indices of the columns that hold words; the others hold numbers.
    """

    def kind(place: int) -> str:
        return ' class="words"' if place in words else ""

    head = "".join(f'<th scope="col"{kind(i)}>{html(each)}</th>' for i, each in enumerate(headings))
    body = []
    for first, *others in rows:
        cells = "".join(f"<td{kind(i)}>{html(cell)}</td>" for i, cell in enumerate(others, start=1))
        body.append(f'<tr><th scope="row" class="words">{html(first)}</th>{cells}</tr>')
    return Markup(
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}">'
        f'<table class="data"><caption>{html(caption)}</caption><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
    )


def terms(fields: Mapping[str, object]) -> Markup:
    """Return terms and their values as a list."""
    pairs = (f"<dt>{escape(term)}</dt><dd>{html(value)}</dd>" for term, value in fields.items())
    return Markup(f"<dl>{''.join(pairs)}</dl>")


def letters(state: str, meanings: Sequence[str]) -> Markup:
    """Return a state as a row of coloured letters, each with its meaning."""
    spans = (
        f'<span class="letter p-{escape(letter)}" title="{escape(meaning)}">{escape(letter)}</span>'
        for letter, meaning in zip(state, meanings, strict=True)
    )
    return Markup("".join(spans))
