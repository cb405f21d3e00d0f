"""``cb show mesh``: a mesh as a form for objects of stages."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.numeric.box_cover import Cover

Mesh = Annotated[Path, typer.Argument(help="Closed mesh, .stl or .obj.")]
Pieces = Annotated[int, typer.Option("--pieces", min=1, max=16, help="Maximum number of boxes.")]
Scale = Annotated[
    float, typer.Option("--scale", help="Length of the mesh's unit, m: 0.001 for mm.")
]


def show_mesh(
    mesh: Mesh,
    *,
    pieces: Pieces = 16,
    scale: Scale = 1.0,
    format_: PlainFormat = "text",
    as_json: Json = False,
) -> None:
    """Print the boxes that fill a closed mesh, as the form of an object of a stage.

    Exit 0 if boxes were found, 2 if the mesh is missing, not closed, or not of an object's size.
    """
    form = read_format(format_, as_json, PLAIN)
    with needing_simulation():
        from cbdsl.numeric.box_cover import cover
        from cbdsl.robot.meshes.triangles import read_triangles
    if scale <= 0:
        raise UsageError(f"--scale {scale:g}: a unit has more than 0 m")
    filling = cover(read_triangles(mesh, scale), pieces)
    if not len(filling.boxes):
        raise UsageError(f"{mesh}: thinner than a 32nd of its length, which no box fills")
    if form is Format.JSON:
        print_json({"fills": filling.share, "form": _form(filling)})
        return
    print(f"# {len(filling.boxes)} boxes, which fill {100 * filling.share:.0f} % of {mesh.name}")
    print("form:\n  shape: composed\n  pieces:")
    for centre, edges in filling.boxes:
        position, size = ", ".join(_lengths(centre)), ", ".join(_lengths(edges))
        print(f"    - {{form: {{shape: box, size: [{size}]}}, position: [{position}]}}")


def _form(filling: Cover) -> dict[str, object]:
    """Return boxes as the form of an object."""
    pieces = [
        {"form": {"shape": "box", "size": _lengths(edges)}, "position": _lengths(centre)}
        for centre, edges in filling.boxes
    ]
    return {"shape": "composed", "pieces": pieces}


def _lengths(values: Iterable[float]) -> list[str]:
    return [f"{1000 * value:.1f} mm" for value in values]
