"""The lines of a text, as the places of findings count them."""

from __future__ import annotations

import re

# What YAML 1.1, and so libyaml, takes for the end of a line.
_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")


def lines_of(text: str) -> list[str]:
    """All lines without their ends."""
    return _BREAK.split(text)


def line_ends(text: str) -> list[str]:
    """Return the ends of all lines but the last."""
    return _BREAK.findall(text)
