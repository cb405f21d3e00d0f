"""Formats of other tools for recorded episodes, which packages add."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cbdsl.types.registry import PluginError, Registry


class Export(NamedTuple):
    """Format of other tools for recorded episodes.

    ``write(recordings, target, **options)`` writes an iterable of ``Recorded`` episodes to a path
    and returns a phrase about the contents, such as ``12 messages``. Its keyword-only parameters
    are the options of the command, and its docstring is the help. It raises UsageError for
    recordings that it cannot write, and OSError if the target cannot be written. The function
    imports heavy packages itself, because a list of commands imports its module.

    Attributes:
        write: Function that writes the format.
        suffix: File suffix, such as ``.mcap``, of a format with one file for each recording.
        folder: Name of the default folder of a format that joins all recordings.
    """

    write: Callable[..., str]
    suffix: str = ""
    folder: str = ""


def _validate(name: str, entry: object) -> Export:
    if not isinstance(entry, Export):
        raise PluginError(f"is a {type(entry).__name__}, not an Export")
    if bool(entry.suffix) == bool(entry.folder) or not callable(entry.write):
        raise PluginError("has not one of 'suffix' and 'folder', or no function 'write'")
    if not entry.write.__doc__:
        raise PluginError("has no help: give its function 'write' a docstring")
    return entry


EXPORTS: Registry[Export] = Registry(
    "export",
    "cbdsl.exports",
    {},
    _validate,
    providers={"mcap": "cbdsl[mcap]", "ros2": "cbdsl[ros2]", "lerobot": "cbdsl[lerobot]"},
)
