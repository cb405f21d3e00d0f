"""Rules of git about files that it ignores."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.storage.contents import contents

if TYPE_CHECKING:
    from pathspec import GitIgnoreSpec


# Larger files, and patterns that are long or have many stars, are skipped: stars backtrack.
_MOST_BYTES = 100_000
_LONGEST = 200
_MOST_STARS = 6


class _Patterns(NamedTuple):
    """Patterns of one file, relative to a folder."""

    folder: Path
    spec: GitIgnoreSpec


class GitIgnore:
    """Rules about the files below a folder.

    Args:
        patterns: Patterns of all files with rules, those of outer folders first.
    """

    def __init__(self, patterns: tuple[_Patterns, ...] = ()) -> None:
        self._patterns = patterns

    @classmethod
    def above(cls, folder: Path) -> GitIgnore:
        """Read the rules of the folders above, up to the root of the repository.

        If they ignore the folder itself, the result is empty; else all of its files would be
        ignored.
        """
        root = next((each for each in folder.parents if (each / ".git").exists()), None)
        # The rules of one repository do not apply within another.
        if root is None or (folder / ".git").exists():
            return cls()
        outer = cls()
        inside = [each for each in reversed(folder.parents) if each.is_relative_to(root)]
        for each, below in zip(inside, [*inside[1:], folder], strict=True):
            outer = outer.with_folder(each)
            if outer.ignores(below, is_folder=True):
                return cls()
        return outer

    def with_folder(self, folder: Path) -> GitIgnore:
        """Add the rules that a folder has itself.

        Args:
            folder: Absolute path of the folder.
        """
        # Later patterns decide: .gitignore has precedence over the file exclude, as in git.
        files = (folder / ".git/info/exclude", folder / ".gitignore")
        own = [_Patterns(folder, spec) for file in files for spec in _read(file)]
        return GitIgnore((*self._patterns, *own)) if own else self

    def ignores(self, path: Path, *, is_folder: bool) -> bool:
        """Return whether a file or folder is ignored; the innermost rule about it decides.

        Args:
            path: Absolute path.
            is_folder: True if it is a folder.
        """
        for patterns in reversed(self._patterns):
            relative = path.relative_to(patterns.folder).as_posix() + "/" * is_folder
            verdict = patterns.spec.check_file(relative).include
            if verdict is not None:
                return verdict
        return False


def _read(file: Path) -> Iterator[GitIgnoreSpec]:
    """Read the patterns of a file, if it exists; malformed lines match nothing."""
    if not os.path.isfile(file):
        return
    try:
        lines = contents(file, _MOST_BYTES).decode("utf-8", "replace").splitlines()
    except OSError:
        return
    from pathspec import GitIgnoreSpec  # few folders need it

    yield GitIgnoreSpec.from_lines(line for line in lines if _is_pattern(line))


def _is_pattern(line: str) -> bool:
    if len(line) > _LONGEST or line.count("*") > _MOST_STARS:
        return False
    from pathspec import GitIgnoreSpec

    try:
        GitIgnoreSpec.from_lines([line])
    except ValueError:
        return False
    return True
