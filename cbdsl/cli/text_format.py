"""Findings for people: each with its line, a caret, and what would have been right."""

from __future__ import annotations

import os
import sys

from cbdsl.cli.outcome import Outcome
from cbdsl.errors.counting import count


def text(outcome: Outcome) -> str:
    """Findings, and how many there are; in colour where a terminal shows them."""
    if not outcome.findings:
        return f"{count(outcome.documents, 'document')}, no findings"
    from cbdsl.errors.rendering import render  # only a finding needs it

    color = _is_colorful()
    told = [render(d, outcome.text_of(d.place.file), color) for d in outcome.findings]
    return "\n".join([*told, _tally(outcome)])


def _tally(outcome: Outcome) -> str:
    numbers = {"error": outcome.errors, "warning": outcome.warnings}
    tally = ", ".join(count(number, noun) for noun, number in numbers.items() if number)
    return tally + (f"; {outcome.left_out} more are left out" if outcome.left_out else "")


def _is_colorful() -> bool:
    """Whether the standard output shows colours and nobody said that they are unwanted."""
    wanted = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    return wanted and sys.stdout.isatty()
