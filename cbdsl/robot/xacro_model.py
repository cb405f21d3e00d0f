"""Expansion of xacro, the macros in which many models are written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

import xacro
import xacro.substitution_args

from cbdsl.errors.nearest import suggestion
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.urdf import UrdfError


def expand_xacro(path: Path, arguments: Mapping[str, str], packages: PackageFolders) -> str:
    """Text of the URDF that a xacro file stands for.

    Args:
        path: of the xacro file.
        arguments: of the file, as ``name:=value`` gives them to xacro.
        packages: where ``$(find NAME)`` looks.

    Raises:
        UrdfError: it is no xacro, a package is nowhere, or it has no such argument.
    """
    known = _AskedArguments(arguments)
    absent: list[UrdfError] = []
    try:
        # Its warnings carry the colours and the frames of a stack, and a mistake is told below.
        with _finding(packages.folder, absent), redirect_stderr(StringIO()):
            document = xacro.process_file(str(path), mappings=known)
    except Exception as error:
        if absent:  # which xacro has wrapped, and says twice
            raise UrdfError(f"{path}: {absent[0]}") from None
        # Expressions of the file are evaluated, and raise whatever such code raises.
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
        asked: these names.
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


@contextmanager
def _finding(find: Callable[[str], Path], absent: list[UrdfError]) -> Iterator[None]:
    """Look packages up here while xacro expands, and not in an installed ROS.

    Errors of packages that are nowhere are added to ``absent``.
    """
    substitution: Any = xacro.substitution_args
    own, table = substitution._eval_find, substitution._eval_dict

    def find_text(name: str) -> str:
        try:
            return str(find(name))
        except UrdfError as error:
            absent.append(error)
            raise

    substitution._eval_find = table["find"] = find_text
    try:
        yield
    finally:
        substitution._eval_find = table["find"] = own


def _reason(error: Exception) -> str:
    """The error's own sentence, in one line."""
    return " ".join(str(error).split()) or type(error).__name__
