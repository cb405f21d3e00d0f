"""Documents and robots that several checks share, each read and checked once."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar
from weakref import WeakKeyDictionary

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.robot import examine_robot
from cbdsl.checking.sound_controllers import SoundControllers
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.document import Document
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.loaded import Loaded

if TYPE_CHECKING:
    from cbdsl.program.checked import CheckedProgram


D = TypeVar("D", bound=Document)

_Key = tuple[Path, frozenset[tuple[str, str]]]
_Robots = dict[Path, tuple[Outcome[CheckedRobot], Diagnostics]]

# Checked robots, which all sessions of a library share: they take most of the time.
_ROBOTS: WeakKeyDictionary[Library, _Robots] = WeakKeyDictionary()


class ProgramCheck(NamedTuple):
    """Result of a check, its diagnostics, and the programs that it bound to a robot, by file."""

    program: Outcome[CheckedProgram]
    diagnostics: Diagnostics
    bindings: Mapping[Path, Loaded[Any]]


class Session:
    """Documents of one invocation.

    Attributes:
        library: Library that finds documents by name.
        values: Values of programs' parameters.
        uses: Graph of the uses between programs.
    """

    def __init__(
        self, library: Library | None = None, values: Mapping[str, str] | None = None
    ) -> None:
        self.library, self.values = library or Library(), values or {}
        self.uses = Uses(self.library)
        self._bodies = _ROBOTS.setdefault(self.library, {})
        self._programs: dict[_Key, ProgramCheck] = {}
        self._sound: dict[Path, SoundControllers] = {}

    def read(
        self, path: Outcome[Path], kind: type[D], diagnostics: Diagnostics
    ) -> Outcome[Loaded[D]]:
        """Return a file's document; add its errors to the diagnostics."""
        if isinstance(path, Unknown):
            return UNKNOWN
        try:
            return self.library.read(path, kind)
        except DiagnosticsError as error:
            diagnostics.extend(error.diagnostics)
            return UNKNOWN

    def body(self, path: Outcome[Path], diagnostics: Diagnostics) -> Outcome[CheckedRobot]:
        """Return the robot of a file, and add its own diagnostics.

        Returns:
            Robot; unknown also if parts of its document had to be left out.
        """
        if isinstance(path, Unknown):
            return UNKNOWN
        key = self.library.real(path)
        if key not in self._bodies:
            own = Diagnostics()
            self._bodies[key] = self._examine_robot(path, own), own
        body, own = self._bodies[key]
        diagnostics.extend(own.sorted())
        return body

    def _examine_robot(self, path: Path, diagnostics: Diagnostics) -> Outcome[CheckedRobot]:
        try:
            loaded = self.library.read_sound_parts(path, RobotDocument)
        except DiagnosticsError as error:
            diagnostics.extend(error.diagnostics)
            return UNKNOWN
        diagnostics.extend(loaded.diagnostics)
        body = examine_robot(loaded, diagnostics)
        return UNKNOWN if loaded.diagnostics else body

    def sound(self, path: Path) -> SoundControllers:
        """Return the controllers of a program's file that had no diagnostics in earlier checks."""
        return self._sound.setdefault(self.library.real(path), SoundControllers())

    def replace(self, path: Path, data: bytes) -> bool:
        """Replace the bytes of a file in the session.

        Programs are checked again. Results for robots are kept, because they take most of the time.

        Returns:
            True if the session can go on; false if a robot may have changed.
        """
        if not self.library.replace(path, data):
            return False
        self.uses = Uses(self.library)
        # Any program may depend on the replaced file, directly or through other documents.
        self._programs.clear()
        return True

    def recall(self, path: Path, values: Mapping[str, str]) -> ProgramCheck | None:
        """Return the last check of a program with these values; its programs are bound again."""
        known = self._programs.get((self.library.real(path), frozenset(values.items())))
        if known is not None:
            self.library.bind_again(known.bindings)
        return known

    def remember(self, path: Path, values: Mapping[str, str], check: ProgramCheck) -> None:
        """Keep the result of a program's check, so that it is checked once for all its uses."""
        self._programs[self.library.real(path), frozenset(values.items())] = check


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
            document = self._library.read_as_written(as_found, ProgramDocument).document
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
