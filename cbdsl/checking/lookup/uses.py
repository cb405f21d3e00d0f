"""Uses of programs by programs, and circles among them."""

from __future__ import annotations

from pathlib import Path

from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.yaml_text.library import Library


class Uses:
    """Graph of programs by their files, because a name may differ from its file's."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._used: dict[Path, tuple[Path, ...]] = {}
        self._as_found: dict[Path, Path] = {}

    def find_path(self, start: Path, goal: Path) -> tuple[Path, ...]:
        """Return the shortest path of uses from one program to another, with both; empty for none.

        Args:
            start: File of a program.
            goal: File of another program; if it is the same, the path has no use.
        """
        first, wanted = self._real(start), self._real(goal)
        # The first program precedes itself, which is where ``_traced`` ends.
        before = {first: first}
        waiting = list(before)
        for path in waiting:  # the list grows
            if path == wanted:
                return _traced(path, before)
            for used in self._uses(path):
                if used not in before:
                    before[used] = path
                    waiting.append(used)
        return ()

    def _uses(self, path: Path) -> tuple[Path, ...]:
        """Return the files of the programs that one uses, as far as they exist."""
        if path not in self._used:
            self._used[path] = tuple(self._read(path))
        return self._used[path]

    def _read(self, path: Path) -> list[Path]:
        from cbdsl.documents.program import ProgramDocument  # only needed if programs use others

        as_found = self._as_found[path]
        try:
            document = self._library.read_sound_parts(as_found, ProgramDocument).document
        except DiagnosticsError:
            return []
        uses = document.use.values()
        files = [self._library.find(ProgramDocument, use.program, as_found) for use in uses]
        return [self._real(file) for file in files if file is not None]

    def _real(self, path: Path) -> Path:
        """Return the resolved file; its diagnostics name the file as it was found."""
        real = self._library.real(path)
        self._as_found.setdefault(real, path)
        return real


def _traced(path: Path, before: dict[Path, Path]) -> tuple[Path, ...]:
    path_back = [path]
    while before[path_back[-1]] != path_back[-1]:
        path_back.append(before[path_back[-1]])
    return tuple(reversed(path_back))
