"""Missing and damaged mesh files of a robot's model."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from cbdsl.robot.meshes.mesh_damage import mesh_damage
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.urdf import UrdfModel

#: Bytes of a model's meshes that are read, the smallest file first.
MOST_BYTES = 100_000_000


class FaultyMesh(NamedTuple):
    """Missing or damaged mesh.

    Attributes:
        file: Path as the model names it.
        link: Link that has it.
        damage: Damage as a clause; empty if the file is missing.
    """

    file: str
    link: str
    damage: str = ""


def missing_meshes(model: UrdfModel) -> list[FaultyMesh]:
    """Return the meshes whose files do not exist, in the order of the model."""
    folder, meshes = model.path.parent, model.meshes.items()
    return [FaultyMesh(name, link) for name, link in meshes if find_mesh(name, folder) is None]


def damaged_meshes(model: UrdfModel) -> list[FaultyMesh]:
    """Return the meshes whose files are damaged, in the order of the model.

    Of files that exceed the bound together, the largest are not read.
    """
    files = dict(_files(model))
    ordered = sorted(set(files.values()), key=lambda file: (_size(file), file))
    totals = accumulate(map(_size, ordered))
    # The sizes are sorted, and thus their sums, too.
    within = {file for file, total in zip(ordered, totals, strict=True) if total <= MOST_BYTES}
    faults = (
        FaultyMesh(name, model.meshes[name], mesh_damage(file))
        for name, file in files.items()
        if file in within or _size(file) > MOST_BYTES
    )
    return [fault for fault in faults if fault.damage]


def _files(model: UrdfModel) -> Iterator[tuple[str, Path]]:
    for name in model.meshes:
        file = find_mesh(name, model.path.parent)
        if file is not None:
            yield name, file


def _size(file: Path) -> int:
    try:
        return file.stat().st_size
    except OSError:  # removed in the meantime, which its check reports
        return 0
