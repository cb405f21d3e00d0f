"""CB7nn: warnings about what has no effect."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, program
from cbdsl.errors.diagnostic import Severity
from cbdsl.errors.entry import Entry

_LOOK = "potential: spring, reference: 0, feedback: cyclopean.$feature, effector: head"

UNUSED = (
    Entry(
        "CB701",
        "unused controller or program",
        "'{name}' is never used",
        "No action and no background runs it.",
        f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\nactions: [track]\n",
        severity=Severity.WARNING,
        good=f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\n"
        "actions: [search, track]\n",
    ),
    Entry(
        "CB702",
        "unused parameter",
        "the parameter '{name}' is never used",
        "Setting it would change nothing.",
        program("parameters: {feature: motion}\nactions: [track]\n"),
        severity=Severity.WARNING,
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB703",
        "name with two meanings",
        "'{name}' hides the {other} of the same name",
        "The nearer meaning wins, which is easily misread.",
        f"{HEAD}parameters: {{feature: motion}}\ncontrollers:\n"
        f"  watch: {{parameters: [feature], {_LOOK}}}\n  look: {{{_LOOK}}}\n"
        "actions: [watch(motion), look]\n",
        severity=Severity.WARNING,
        good=f"{HEAD}parameters: {{feature: motion}}\ncontrollers:\n"
        f"  watch: {{parameters: [channel], {_LOOK.replace('feature', 'channel')}}}\n"
        f"  look: {{{_LOOK}}}\nactions: [watch(motion), look]\n",
    ),
)
