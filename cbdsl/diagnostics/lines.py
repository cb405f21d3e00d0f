"""Lines of a text, counted as in the places of diagnostics."""

from __future__ import annotations

import re

# Line breaks of YAML 1.1, and therefore of libyaml.
_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")


def lines_of(text: str) -> list[str]:
    """Return all lines without their ends."""
    return _BREAK.split(text)


def line_ends(text: str) -> list[str]:
    """Return the ends of all lines but the last."""
    return _BREAK.findall(text)
