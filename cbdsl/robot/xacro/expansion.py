"""Expansion of xacro, the macros in which many models are written.

The library's macros are used with bounded parts of this project in place of those that run code,
read the environment or open any file: see :mod:`cbdsl.robot.xacro.library_parts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

import xacro

from cbdsl.errors.nearest import suggestion
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.urdf import UrdfError
from cbdsl.robot.xacro.library_parts import LibraryParts


def expand_xacro(path: Path, arguments: Mapping[str, str], packages: PackageFolders) -> str:
    """Return the text of the URDF that a xacro file stands for.

    Args:
        path: Xacro file.
        arguments: Values by name, as ``name:=value`` gives them to xacro.
        packages: Folders of packages, for ``$(find NAME)``.

    Raises:
        UrdfError: The file is not xacro, asks for what is refused, or names an absent package or
            an unknown argument.
    """
    known = _AskedArguments(arguments)
    parts = LibraryParts(known, packages)
    try:
        # Its warnings carry the colours and the frames of a stack, and a mistake is told below.
        with parts.installed(), redirect_stderr(StringIO()):
            document = xacro.process_file(str(path), mappings=known)
    except RecursionError:
        raise UrdfError(f"{path}: xacro cannot expand it: one of its macros uses itself") from None
    except Exception as error:
        if parts.refusals:  # which xacro has wrapped, and says twice
            raise UrdfError(f"{path}: {parts.refusals[0]}") from None
        # Expressions and macros of the file raise whatever they raise.
        raise UrdfError(f"{path}: xacro cannot expand it: {_reason(error)}") from None
    unknown = next((name for name in arguments if name not in known.asked), None)
    if unknown is not None:
        names = ", ".join(sorted(known.asked)) or "none"
        raise UrdfError(
            f"{path}: it has no argument '{unknown}'"
            f"{suggestion(unknown, known.asked)} (known: {names})"
        )
    _drop_repeated_materials(document.documentElement)
    return str(document.documentElement.toxml())


def _drop_repeated_materials(robot: Any) -> None:
    """Keep one of the materials that a macro gives anew wherever it is used: readers want one."""
    seen: set[str] = set()
    for element in list(robot.childNodes):
        if getattr(element, "tagName", "") == "material":
            text = "".join(element.toxml().split())
            if text in seen:
                robot.removeChild(element)
            seen.add(text)


class _AskedArguments(dict[str, str]):
    """Arguments of a xacro file, and the names that it has declared or read.

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
