"""Checks of a stage's meshes: their files exist and are usable as things."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.form import MOST_PIECES, MeshForm
from cbdsl.documents.stage import StageDocument
from cbdsl.storage.contents import is_file, is_folder
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

if TYPE_CHECKING:
    from cbdsl.robot.meshes.mesh_reader import Mesh

_ENDINGS = (".stl", ".obj")


def check_meshes(loaded: Loaded[StageDocument], diagnostics: Diagnostics) -> None:
    """Check that each mesh of a stage can be read, and can be a thing."""
    for steps, form in _meshes(loaded.document):
        if is_file(form.path):
            _readable(loaded, diagnostics, steps, form)
        else:
            place = loaded.source.place(*steps, "form", "file")
            folder = form.path.parent
            beside = folder.glob("*") if is_folder(folder) else ()
            names = [each.name for each in beside if each.suffix.lower() in _ENDINGS]
            diagnostics.add("CB364", place, names=names, name=form.file, folder=_folder(form))


def extents_of(form: MeshForm) -> tuple[float, float, float] | None:
    """Return the edges of the box around a mesh, m, or ``None`` if it cannot be read."""
    try:
        from cbdsl.robot.meshes.thing_mesh import read_thing_mesh  # few stages have any

        x, y, z = read_thing_mesh(form.path, form.scale).halves
    except (UsageError, ImportError):  # an installation for checks alone may have no arrays
        return None
    return 2 * x, 2 * y, 2 * z


def _meshes(stage: StageDocument) -> Iterator[tuple[tuple[Step, ...], MeshForm]]:
    for section, items in (("fixtures", stage.fixtures), ("things", stage.things)):
        for name, item in items.items():
            if isinstance(item.form, MeshForm):
                yield (section, name), item.form


def _readable(
    loaded: Loaded[StageDocument], diagnostics: Diagnostics, steps: tuple[Step, ...], form: MeshForm
) -> None:
    try:
        from cbdsl.robot.meshes.thing_mesh import read_thing_mesh
    except ImportError:
        return
    try:
        mesh = read_thing_mesh(form.path, form.scale).mesh
        problem = _unfilled(mesh) if form.solid == "boxes" else ""
    except UsageError as error:
        problem = str(error).removeprefix(f"{form.path}: ")
    if problem:
        place = loaded.source.place(*steps, "form", "file")
        diagnostics.add("CB365", place, name=form.file, problem=problem)


def _unfilled(mesh: Mesh) -> str:
    from cbdsl.numeric.box_cover import cover

    if len(cover(mesh.corners[mesh.triangles], MOST_PIECES).boxes):
        return ""
    return (
        "thinner than a 32nd of its length, which no box fills; its hull, or what is around it, can"
    )


def _folder(form: MeshForm) -> str:
    folder = form.path.parent
    return str(folder) if is_folder(folder) else f"{folder}, which is not there either"
