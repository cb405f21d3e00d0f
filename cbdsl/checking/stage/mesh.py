"""Meshes that a stage names: they are there, and may be things."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.checking.findings import Findings
from cbdsl.documents.stage import MeshForm, StageDocument
from cbdsl.errors.errors import UsageError
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

_ENDINGS = (".stl", ".obj")


def check_meshes(loaded: Loaded[StageDocument], findings: Findings) -> None:
    """Check that each mesh of a stage can be read, and is that of a thing."""
    for steps, form in _meshes(loaded.document):
        if form.path.is_file():
            _readable(loaded, findings, steps, form)
        else:
            place = loaded.source.place(*steps, "form", "file")
            beside = [each for each in form.path.parent.glob("*") if _is_mesh(each.suffix)]
            names = [str(form.path.with_name(each.name).name) for each in beside]
            findings.add("CB364", place, names=names, name=form.file, folder=_folder(form))


def extents_of(form: MeshForm) -> tuple[float, float, float] | None:
    """The edges of the box around a mesh, m, or ``None`` where it cannot be read."""
    from cbdsl.robot.thing_mesh import read_thing_mesh  # few stages have any

    try:
        x, y, z = read_thing_mesh(form.path, form.scale).halves
    except UsageError:
        return None
    return 2 * x, 2 * y, 2 * z


def _meshes(stage: StageDocument) -> Iterator[tuple[tuple[Step, ...], MeshForm]]:
    for section, items in (("fixtures", stage.fixtures), ("things", stage.things)):
        for name, item in items.items():
            if isinstance(item.form, MeshForm):
                yield (section, name), item.form


def _readable(
    loaded: Loaded[StageDocument], findings: Findings, steps: tuple[Step, ...], form: MeshForm
) -> None:
    try:
        from cbdsl.robot.thing_mesh import read_thing_mesh
    except ImportError:  # whoever checks without a simulator has no arrays
        return
    try:
        read_thing_mesh(form.path, form.scale)
    except UsageError as error:
        place = loaded.source.place(*steps, "form", "file")
        problem = str(error).removeprefix(f"{form.path}: ")
        findings.add("CB365", place, name=form.file, problem=problem)


def _folder(form: MeshForm) -> str:
    folder = form.path.parent
    return str(folder) if folder.is_dir() else f"{folder}, which is not there either"


def _is_mesh(ending: str) -> bool:
    return ending.lower() in _ENDINGS
