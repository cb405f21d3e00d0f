"""Reasons why a file or a folder cannot be used, in words."""

from __future__ import annotations

# The system's messages for these errors describe the attempt, not the obstacle.
_WORDS: dict[type[OSError], str] = {
    FileExistsError: "a file exists where a folder is needed",
    NotADirectoryError: "a file exists on the way, where folders are needed",
    IsADirectoryError: "this is a folder",
}


def reason(error: OSError) -> str:
    """Return the reason why a file or a folder cannot be used, without its name."""
    return _WORDS.get(type(error)) or error.strerror or str(error)
