"""Files of the meshes that a URDF names."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from cbdsl.storage.contents import is_file


def find_mesh(name: str, folder: Path) -> Path | None:
    """Return the file that a URDF in ``folder`` names, or ``None`` if it is missing.

    ``package://name/path`` is searched below every folder above, with and without the package name.
    """
    # Addresses may hold escapes, such as %20 for a space.
    plain = unquote(name)
    if "://" not in plain:
        file = folder / plain
        return file if is_file(file) else None
    scheme, _, path = plain.partition("://")
    if scheme == "file":
        return Path(path) if is_file(Path(path)) else None
    inner = path.partition("/")[2]
    # A model may lie within its package or within a copy of the package's contents. Only in the
    # first case its address holds the name of a folder on the way. The nearest folder has
    # precedence.
    for base in (folder, *folder.parents):
        for candidate in (base / path, base / inner):
            if inner and is_file(candidate):
                return candidate
    return None
