"""Formats of robot models and scenes from packages, converted to URDF and to stages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.types.registry import PluginError, Registry


class ConvertedModel(NamedTuple):
    """Robot or scene in a format that this package reads.

    Attributes:
        text: Text of the URDF of a robot, or of the document of a stage.
        meshes: Contents of mesh files, by their names in the text.
        remarks: Sentences about parts of the model that have no counterpart.
    """

    text: str
    meshes: Mapping[str, bytes] = {}
    remarks: tuple[str, ...] = ()


class ModelFormat(NamedTuple):
    """Format of robot models.

    Attributes:
        summary: Format, as a phrase.
        convert: ``module:function`` of (path, name, arguments, packages) -> ConvertedModel: the
            URDF of a file, for the name of the robot, values of the file's arguments by name, and
            the folders of packages. It raises UrdfError for a file that it cannot convert, and
            reads no other files than the model names.
    """

    summary: str
    convert: str

    def converted(
        self, path: Path, name: str, arguments: Mapping[str, str], packages: PackageFolders
    ) -> ConvertedModel:
        """Return the model in URDF.

        Raises:
            UrdfError: The file cannot be converted.
            ModuleNotFoundError: A package of the format is not installed.
        """
        module, _, function = self.convert.partition(":")
        convert: Callable[..., ConvertedModel] = getattr(import_module(module), function)
        return convert(path, name, arguments, packages)


def _validate(_: str, entry: object) -> ModelFormat:
    if not isinstance(entry, ModelFormat) or entry.convert.count(":") != 1:
        raise PluginError("is no ModelFormat with 'module:function'")
    return entry


_PROVIDERS = dict.fromkeys(("mjcf", "xacro"), "cbdsl[formats]")
MODEL_FORMATS: Registry[ModelFormat] = Registry(
    "format of models", "cbdsl.models", {}, _validate, providers=_PROVIDERS
)
#: Formats of scenes, whose functions return the parts of a stage in the place of a URDF.
SCENE_FORMATS: Registry[ModelFormat] = Registry(
    "format of scenes", "cbdsl.scenes", {}, _validate, providers=_PROVIDERS
)
