"""URDF text for another folder, with paths of meshes relative to it."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.robot_xml import xml_root
from cbdsl.robot.urdf import UrdfError
from cbdsl.storage.contents import is_file


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
