"""Words of commands from arguments of a client, which may be wrong or hostile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from mcp.server.mcpserver.exceptions import ToolError

#: Backends that simulate a robot; all others may move a real one.
SIMULATORS = ("kinematic", "mujoco", "bullet")


def plain(name: str, value: str) -> str:
    """Return a word that cannot be an option of a command.

    Raises:
        ToolError: It is empty, or begins like an option.
    """
    if not value.strip() or value.startswith("-") or "\0" in value or "\n" in value:
        raise ToolError(f"{name}: {value!r} is neither a name nor a file")
    return value


def within(name: str, value: str, folder: Path) -> str:
    """Return a name or a file inside of a folder.

    Raises:
        ToolError: It is an option, or leads out of the folder.
    """
    place = (folder / plain(name, value)).resolve()
    if not place.is_relative_to(folder.resolve()):
        raise ToolError(f"{name}: {value!r} is outside of {folder}")
    return value


def options(given: Mapping[str, object]) -> Iterator[str]:
    """Yield the options of a command; those without a value are left out."""
    for name, value in given.items():
        if value is True:
            yield f"--{name}"
        elif isinstance(value, Mapping):
            yield from (f"--{name}={key}={each}" for key, each in value.items())
        elif value is not None and value is not False:
            yield f"--{name}={value}"
