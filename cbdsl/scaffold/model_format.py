"""Formats of robot models from packages, which are expanded to URDF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.types.registry import PluginError, Registry


class ModelFormat(NamedTuple):
    """Format of robot models.

    Attributes:
        summary: Format, as a phrase.
        expand: ``module:function`` of (path, arguments, packages) -> text: the URDF of a file, for
            values of its arguments by name, and the folders of packages. It raises UrdfError for a
            file that it cannot expand, and reads no other files than the model names.
    """

    summary: str
    expand: str

    def expanded(self, path: Path, arguments: Mapping[str, str], packages: PackageFolders) -> str:
        """Return the URDF text of a file.

        Raises:
            UrdfError: The file cannot be expanded.
            ModuleNotFoundError: A package of the format is not installed.
        """
        module, _, name = self.expand.partition(":")
        expand: Callable[..., str] = getattr(import_module(module), name)
        return expand(path, arguments, packages)


def _validate(_: str, entry: object) -> ModelFormat:
    if not isinstance(entry, ModelFormat) or entry.expand.count(":") != 1:
        raise PluginError("is no ModelFormat with 'module:function'")
    return entry


MODEL_FORMATS: Registry[ModelFormat] = Registry(
    "format of models", "cbdsl.models", {}, _validate, providers={"xacro": "cbdsl[formats]"}
)
