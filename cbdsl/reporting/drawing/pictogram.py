"""States as rows of small pictograms, one per member, like the icons of Figure 4.2."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

#: Edge of a pictogram, and from one to the next, px.
EDGE = 24
PITCH = 29


class Letter(NamedTuple):
    """Predicate (Eq 4.1), or ``*`` for any.

    Attributes:
        meaning: Meaning in words.
        symbol: One character, for use without pictures.
        paper: Background colour.
        ink: Colour of the sign.
    """

    meaning: str
    symbol: str
    paper: str
    ink: str


#: The colours are those of replays; the signs differ, too, for colour-blind readers.
LETTERS = {
    "X": Letter("not active", "✕", "#e3e6ea", "#4d555e"),
    "-": Letter("undefined", "−", "#f3c98b", "#4a2c00"),  # noqa: RUF001
    "0": Letter("on its way", "○", "#a9cdf0", "#062c4d"),
    "1": Letter("at rest", "●", "#9fd8ae", "#05330f"),
    "*": Letter("any", "∗", "#ffffff", "#4d555e"),  # noqa: RUF001
}

# Around the middle of a square of 24 px.
_SIGNS = {
    "X": '<path d="M-5-5L5 5M-5 5L5-5" fill="none" stroke-width="2"/>',
    "-": '<path d="M-6 0H6" fill="none" stroke-width="3"/>',
    "0": '<circle r="5.5" fill="none" stroke-width="2.5"/>',
    "1": '<circle r="6.5"/>',
    "*": '<path d="M-6 0h0M0 0h0M6 0h0" fill="none" stroke-width="3" stroke-linecap="round"/>',
}


def in_words(state: str, members: Sequence[str]) -> str:
    """Return a state in words, with the meaning of each member's predicate."""
    parts = (
        f"{member} {LETTERS[letter].meaning}"
        for member, letter in zip(members, state, strict=False)
    )
    return ", ".join(parts)


def symbols(state: str) -> str:
    """Return a state in characters that resemble its pictograms."""
    return " ".join(LETTERS[letter].symbol for letter in state)


def width(state: str) -> float:
    """Return the width of a state's pictograms, px."""
    return len(state) * PITCH - (PITCH - EDGE)


def pictograms(
    state: str, members: Sequence[str], programs: Collection[str], left: float, top: float
) -> Iterator[str]:
    """Yield a state as SVG; programs have a second frame.

    Args:
        state: State, one letter per member.
        members: Names of the members.
        programs: Names of the members that are programs.
        left: Left edge, px.
        top: Upper edge, px.
    """
    for place, (letter, member) in enumerate(zip(state, members, strict=False)):
        yield pictogram(letter, member in programs, left + place * PITCH, top)


def pictogram(letter: str, program: bool, left: float, top: float) -> str:
    """Return one letter as SVG; ``left`` and ``top`` are its upper left corner, px."""
    look, half = LETTERS[letter], EDGE / 2
    frames = [_frame(0.5, look), *([_frame(3, look)] if program else [])]
    return (
        f'<g fill="{look.ink}" stroke="{look.ink}" '
        f'transform="translate({left + half:.1f} {top + half:.1f})">'
        f"{''.join(frames)}{_SIGNS[letter]}</g>"
    )


def _frame(inset: float, look: Letter) -> str:
    corner, edge = inset - EDGE / 2, EDGE - 2 * inset
    return (
        f'<rect x="{corner:g}" y="{corner:g}" width="{edge:g}" height="{edge:g}" '
        f'rx="{5.5 - inset:g}" fill="{look.paper}"/>'
    )
