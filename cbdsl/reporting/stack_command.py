"""Command that builds a planned stack."""

from __future__ import annotations

from collections.abc import Sequence

# Programs by number of stacked objects, and their parameters for the channels, from below.
_PROGRAMS = {2: ("stand", ("goal", "feature")), 3: ("stack_three", ("goal", "middle", "feature"))}


def stack_command(channels: Sequence[str]) -> str | None:
    """Return the command that stacks the objects of these channels, from below.

    Returns:
        Command, or ``None`` if no shipped program stacks so many.
    """
    if len(channels) not in _PROGRAMS:
        return None
    program, parameters = _PROGRAMS[len(channels)]
    given = " ".join(f"--with {k}={c}" for k, c in zip(parameters, channels, strict=True))
    return f"cb run {program} {given}"
