"""Folders of the packages that models name, as in ``package://NAME/meshes/link.stl``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from cbdsl.diagnostics.nearest import suggestion
from cbdsl.robot.urdf import UrdfError
from cbdsl.storage.contents import is_folder


class PackageFolders:
    """Folders by the name of their package.

    Args:
        named: Folders that the user names.
        roots: Folders of packages or with packages in them, as in ROS_PACKAGE_PATH.
        model: Path of the model; packages in and beside the folders above it are found.
    """

    def __init__(self, named: Mapping[str, Path], roots: Sequence[Path], model: Path) -> None:
        self._named, self._roots = dict(named), tuple(roots)
        self._above = tuple(model.resolve().parents)

    def folder(self, name: str) -> Path:
        """Return the folder of a package.

        Raises:
            UrdfError: If the package is not found.
        """
        folder = next((each for each in self._candidates(name) if is_folder(each)), None)
        if folder is None:
            raise UrdfError(
                f"package '{name}' is nowhere{suggestion(name, self._named)}; "
                f"--package {name}=FOLDER says where it is, or ROS_PACKAGE_PATH, and so does a "
                "folder of this name above the model"
            )
        return folder.resolve()

    def mesh(self, name: str, folder: Path) -> Path:
        """Return the file of a mesh that a model in a folder names.

        Raises:
            UrdfError: If its package is not found.
        """
        scheme, separator, path = name.partition("://")
        if not separator:
            return folder / name
        if scheme != "package":
            return Path(path)
        # Some models have a third slash, which readers skip.
        package, _, inner = path.lstrip("/").partition("/")
        return self.folder(package) / inner

    def _candidates(self, name: str) -> Iterator[Path]:
        if name in self._named:
            yield self._named[name]
            return  # no other folder replaces a wrong one
        for root in (*self._roots, *self._above):
            if root.name == name:
                yield root
            yield root / name
