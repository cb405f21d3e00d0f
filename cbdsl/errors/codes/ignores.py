"""CB8nn: comments that silence findings."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, program
from cbdsl.errors.diagnostic import Severity
from cbdsl.errors.entry import Entry

_GOOD = (
    f"{HEAD}controllers:\n  search: {SEARCH}  # cb: ignore CB701 the next lesson uses it\n"
    f"  track: {TRACK}\nactions: [track]\n"
)

IGNORES = (
    Entry(
        "CB801",
        "ignore that silences nothing",
        "there is no {ignored} here to ignore",
        "The fault is gone, or is on another line: a comment is for its own line or, on a line of "
        "its own, for the next. An idle one would hide the fault when it comes back.",
        program("actions: [track]  # cb: ignore CB404 it comes later\n"),
        severity=Severity.WARNING,
        good=_GOOD,
    ),
    Entry(
        "CB802",
        "ignore without a reason",
        "nothing says why {ignored} is ignored",
        "The reason follows the code: `# cb: ignore CB701 the next lesson uses it`. Whoever reads "
        "the document later has to know when the comment can go.",
        _GOOD.replace(" the next lesson uses it", ""),
        severity=Severity.WARNING,
        good=_GOOD,
    ),
    Entry(
        "CB803",
        "ignore of an unknown finding",
        "'{name}' is no finding's code",
        "A comment silences one finding, by its code: `# cb: ignore CB701 the next lesson uses "
        "it`. There is no way to silence them all.",
        program("actions: [track]  # cb: ignore everything\n"),
        severity=Severity.WARNING,
        good=_GOOD,
    ),
)
