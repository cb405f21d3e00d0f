"""``cb show mesh``: a mesh as a form that stages can have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Mesh = Annotated[Path, typer.Argument(help="A closed mesh, .stl or .obj.")]
Pieces = Annotated[
    int, typer.Option("--pieces", min=1, max=16, help="Boxes that it is made of at most.")
]
Scale = Annotated[float, typer.Option("--scale", help="Metres in the mesh's unit: 0.001 for mm.")]


def show_mesh(mesh: Mesh, *, pieces: Pieces = 16, scale: Scale = 1.0) -> None:
    """Print the boxes that fill a closed mesh, as the form of a thing of a stage.

    Exit 0 when there are any, 2 when the mesh is not there, not closed, or of no thing's size.
    """
    from cbdsl.cli.simulation import needing_simulation
    from cbdsl.errors.errors import UsageError

    with needing_simulation():
        from cbdsl.numeric.box_cover import cover
        from cbdsl.robot.triangles import read_triangles
    if scale <= 0:
        raise UsageError(f"--scale {scale:g}: a unit has more than 0 m")
    filling = cover(read_triangles(mesh, scale), pieces)
    if not len(filling.boxes):
        raise UsageError(f"{mesh}: thinner than a 32nd of its length, which no box fills")
    print(f"# {len(filling.boxes)} boxes, which fill {100 * filling.share:.0f} % of {mesh.name}")
    print("form:\n  shape: composed\n  pieces:")
    for centre, edges in filling.boxes:
        position, size = (
            ", ".join(f"{1000 * value:.1f} mm" for value in values) for values in (centre, edges)
        )
        print(f"    - {{form: {{shape: box, size: [{size}]}}, position: [{position}]}}")
