"""The command that builds a planned stack."""

from __future__ import annotations

from collections.abc import Sequence

# Programs by how many things they stack, and their parameters for the channels, from below.
_PROGRAMS = {
    2: ("stand", ("goal", "feature")),
    3: ("stack_three", ("goal", "middle", "feature")),
}


def stack_command(channels: Sequence[str]) -> str | None:
    """The command for things that are known by these channels, from below.

    Returns:
        ``None`` where no shipped program stacks so many.
    """
    if len(channels) not in _PROGRAMS:
        return None
    program, parameters = _PROGRAMS[len(channels)]
    given = " ".join(f"--with {k}={c}" for k, c in zip(parameters, channels, strict=True))
    return f"cb run {program} {given}"
