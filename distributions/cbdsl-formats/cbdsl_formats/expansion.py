"""Expansion of xacro, a macro language of robot models.

The library's macros are used. Bounded parts of this project replace the parts that run code, read
the environment or open any file: see :mod:`cbdsl_formats.library_parts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

import xacro

from cbdsl.extend.model import ConvertedModel, PackageFolders, UrdfError, suggestion
from cbdsl_formats.library_parts import LibraryParts


def expand_xacro(
    path: Path, name: str, arguments: Mapping[str, str], packages: PackageFolders
) -> ConvertedModel:
    """Return the URDF of a xacro file.

    Args:
        path: Xacro file.
        name: Unused; the robot's name is in the file.
        arguments: Values by name, in the form of ``name:=value`` in xacro.
        packages: Folders of packages, for ``$(find NAME)``.

    Raises:
        UrdfError: If the file is not xacro, makes a refused request, or names an absent package or
            an unknown argument.
    """
    known = _AskedArguments(arguments)
    parts = LibraryParts(known, packages)
    try:
        # Its warnings contain colours and stack frames; errors are reported below.
        with parts.installed(), redirect_stderr(StringIO()):
            document = xacro.process_file(str(path), mappings=known)
    except RecursionError:
        raise UrdfError(
            f"{parts.place}: xacro cannot expand it: a macro, or a file that it includes, uses "
            "itself"
        ) from None
    except Exception as error:
        place = parts.place or path
        if parts.refusals:  # which xacro has wrapped and repeated
            raise UrdfError(f"{place}: {parts.refusals[0]}") from None
        # Expressions and macros of the file can raise any exception.
        raise UrdfError(f"{place}: xacro cannot expand it: {_reason(error)}") from None
    unknown = next((name for name in arguments if name not in known.asked), None)
    if unknown is not None:
        names = ", ".join(sorted(known.asked)) or "none"
        raise UrdfError(
            f"{path}: it has no argument '{unknown}'"
            f"{suggestion(unknown, known.asked)} (known: {names})"
        )
    _drop_repeated_materials(document.documentElement)
    return ConvertedModel(str(document.documentElement.toxml()))


def _drop_repeated_materials(robot: Any) -> None:
    """Remove repeated materials, which macros add at each use and readers accept once."""
    seen: set[str] = set()
    for element in list(robot.childNodes):
        if getattr(element, "tagName", "") == "material":
            # Copies of a macro may differ in spaces. Materials of one name and different colours
            # stay, and the reader of URDF reports them.
            text = "".join(element.toxml().split())
            if text in seen:
                robot.removeChild(element)
            seen.add(text)


class _AskedArguments(dict[str, str]):
    """Arguments of a xacro file, with the names that it has declared or read.

    Attributes:
        asked: These names.
    """

    def __init__(self, arguments: Mapping[str, str]) -> None:
        super().__init__(arguments)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.asked.add(name)
        return value


def _reason(error: Exception) -> str:
    """Return the error's own sentence, in one line."""
    return " ".join(str(error).split()) or type(error).__name__
