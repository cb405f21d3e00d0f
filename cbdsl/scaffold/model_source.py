"""Robot models in common formats, read as the URDF to which robot documents refer."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

from cbdsl.diagnostics.errors import UsageError
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.robot_xml import MOST_BYTES, robot_text, xml_root
from cbdsl.robot.urdf import UrdfError, UrdfModel
from cbdsl.storage.contents import contents, is_file

if TYPE_CHECKING:
    from cbdsl.robot.srdf import SrdfModel
    from cbdsl.scaffold.model_format import ConvertedModel


class ModelSource(NamedTuple):
    """Model, with the files to write so that a document can refer to it.

    Attributes:
        model: Model read from its file, or from the file that will be written.
        files: Contents of the files to write, by path.
        remarks: Sentences about parts of the source without counterpart.
    """

    model: UrdfModel
    files: Mapping[Path, bytes]
    remarks: tuple[str, ...]


class ModelReader:
    """Reader of URDF, xacro and MJCF.

    Args:
        file: File of the model.
        arguments: Arguments of xacro, each as ``name:=value``.
        packages: Folders of packages, each as ``name=folder``.
        is_xacro: True if the files are xacro without a name that ends in ``.xacro``.

    Raises:
        UsageError: An argument or a package is not of that form.
    """

    def __init__(
        self, file: Path, arguments: Sequence[str], packages: Sequence[str], is_xacro: bool = False
    ) -> None:
        self._file, self._given, self._is_xacro = file, list(packages), is_xacro
        self._arguments = _pairs("--xacro-arg", arguments, ":=")
        self._packages = _package_folders(file, _pairs("--package", packages, "="))

    def read(self, name: str, folder: Path) -> ModelSource:
        """Return the model of a named robot, whose document will be in a folder.

        Raises:
            UsageError: The model cannot be read, or needs a package that is not installed.
        """
        try:
            return self._read(name, folder)
        except UrdfError as error:
            raise UsageError(f"--urdf {error}") from None

    def semantics(self, file: Path) -> SrdfModel:
        """Return the groups of the robot, from SRDF or from xacro that expands to SRDF.

        Raises:
            UsageError: The groups cannot be read, or need a package that is not installed.
        """
        from cbdsl.robot.srdf import parse_srdf, read_srdf

        try:
            if self._format(file) == "xacro":
                return parse_srdf(self._converted(file, "xacro", "", {}).text, file)
            return read_srdf(file)
        except UrdfError as error:
            raise UsageError(f"srdf {error}") from None

    def _read(self, name: str, folder: Path) -> ModelSource:
        from cbdsl.robot.urdf_reader import read_urdf

        # Order: formats that need a conversion come first. A plain URDF is copied only if it lacks
        # a name or the user names packages. Otherwise the document refers to it in place.
        kind = self._format(self._file)
        if self._arguments and kind != "xacro":
            raise UsageError(f"--xacro-arg is for xacro, and {self._file} is none")
        if kind == "mjcf":
            model = self._converted(self._file, kind, name, self._arguments)
            how = "converted from MJCF as MuJoCo compiles it"
            return self._written(model.text, how, name, folder, model.meshes, model.remarks)
        if kind == "xacro":
            text = self._converted(self._file, kind, name, self._arguments).text
            values = "".join(f" {key}:={value}" for key, value in self._arguments.items())
            return self._local(text, f"expanded by xacro{values}", name, folder)
        if kind == "nameless":
            how = "copied, and given a name"
            return self._local(robot_text(self._file), how, name, folder)
        if self._given:
            how = "copied, with its meshes found"
            return self._local(robot_text(self._file), how, name, folder)
        return ModelSource(read_urdf(self._file), {}, ())

    def _format(self, file: Path) -> str:
        """Return ``xacro``, ``mjcf``, ``robot`` or, for a robot without name, ``nameless``.

        The file's name or the user determines whether it is xacro; the contents do not.
        Files that the readers will refuse are ``robot``, too.
        """
        if (file.suffix == ".xacro" or self._is_xacro) and file.is_file():
            return "xacro"
        try:
            root = xml_root(contents(file, MOST_BYTES), file, "URDF")
        except (OSError, UrdfError):
            return "robot"
        if root.tag == "robot" and not root.get("name"):
            return "nameless"  # as some public models are, which no engine reads
        return "mjcf" if root.tag == "mujoco" else "robot"

    def _converted(
        self, file: Path, kind: str, name: str, arguments: Mapping[str, str]
    ) -> ConvertedModel:
        from cbdsl.scaffold.model_format import MODEL_FORMATS

        try:
            return MODEL_FORMATS.get(kind).converted(file, name, arguments, self._packages)
        except ModuleNotFoundError as error:
            raise UsageError(
                f"{file}: {kind} needs {error.name}, which is not installed: "
                "pip install 'cbdsl[formats]'"
            ) from None

    def _local(self, text: str | bytes, how: str, name: str, folder: Path) -> ModelSource:
        urdf = localized(text, self._file, folder, self._packages, name)
        return self._written(urdf, how, name, folder, {}, ())

    def _written(
        self,
        urdf: str,
        how: str,
        name: str,
        folder: Path,
        meshes: Mapping[str, bytes],
        remarks: tuple[str, ...],
    ) -> ModelSource:
        from cbdsl.robot.urdf_reader import parse_urdf

        path = folder / f"{name}.urdf"
        # For example ``cb new robot arm --urdf arm.urdf --to .`` with a model that has to be
        # copied.
        if path.resolve() == self._file.resolve():
            raise UsageError(
                f"{path} would be written over the model itself; give the robot another name, or "
                "--to another folder"
            )
        origin = Path(os.path.relpath(self._file.resolve(), folder.resolve())).as_posix()
        text = with_origin(urdf, f"From {origin}, {how}, by cb new robot {name}.").encode()
        files = {path: text, **{folder / file: stl for file, stl in meshes.items()}}
        model = parse_urdf(text, path)
        len(model.bodies)  # reads the numbers of all links, before anything is written
        return ModelSource(model, files, remarks)


def _package_folders(file: Path, named: Mapping[str, str]) -> PackageFolders:
    # Checked for every model, also for one that refers to no package.
    for name, path in named.items():
        if not (path and Path(path).is_dir()):
            raise UsageError(f"--package {name}={path}: there is no folder '{path}'")
    roots = [Path(root) for root in os.environ.get("ROS_PACKAGE_PATH", "").split(":") if root]
    return PackageFolders({name: Path(path) for name, path in named.items()}, roots, file)


def _pairs(option: str, texts: Sequence[str], separator: str) -> dict[str, str]:
    """Return values by name.

    Raises:
        UsageError: A text has no name or no separator, or two texts have the same name.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        name, found_separator, value = text.partition(separator)
        if not (name and found_separator):
            raise UsageError(f"{option} {text} is not of the form NAME{separator}VALUE")
        # The same value twice, as a script may give it, is no conflict.
        if pairs.setdefault(name, value) != value:
            raise UsageError(f"{option} gives '{name}' twice: {pairs[name]} and {value}")
    return pairs


def localized(
    text: str | bytes, source: Path, folder: Path, packages: PackageFolders, name: str
) -> str:
    """Return a URDF with paths for another folder.

    Args:
        text: Text of the URDF.
        source: Original file, to which the paths of its meshes are relative.
        folder: Folder of the new file.
        packages: Folders of packages, for ``package://NAME``.
        name: Name of the robot, if the URDF has none.

    Raises:
        UrdfError: If it is not XML, or one of its meshes is missing.
    """
    root = xml_root(text, source, "URDF")
    if not root.get("name"):
        root.set("name", name)
    for link in root.findall("link"):
        for mesh in link.iter("mesh"):
            mesh.set(
                "filename", _localized_mesh(mesh, link.get("name", ""), source, folder, packages)
            )
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _localized_mesh(
    mesh: ElementTree.Element, link: str, source: Path, folder: Path, packages: PackageFolders
) -> str:
    name = mesh.get("filename", "")
    try:
        file = packages.mesh(name, source.resolve().parent)
    except UrdfError as error:
        raise UrdfError(f"{source}: link '{link}' has the mesh {name}: {error}") from None
    if not is_file(file):
        raise UrdfError(f"{source}: link '{link}' has the mesh {name}, and {file} is not there")
    return Path(os.path.relpath(file, folder.resolve())).as_posix()


def with_origin(text: str, origin: str) -> str:
    """Return a URDF with a leading comment that states its origin."""
    # Two hyphens end an XML comment.
    return f'<?xml version="1.0"?>\n<!-- {origin.replace("--", "- -")} -->\n{text}\n'
