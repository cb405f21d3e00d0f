"""``cb show``: types, potentials, resources, plug-ins, programs, and learned documents."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.output.terminal import print_json, print_table, warn_of_faults
from cbdsl.cli.show.allocations import show_allocations
from cbdsl.cli.show.bindings import show_bindings
from cbdsl.cli.show.catalog import show_catalog
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.cli.show.knowledge import show_knowledge
from cbdsl.cli.show.mesh import show_mesh
from cbdsl.cli.show.meta_catalog import show_meta_catalog
from cbdsl.cli.show.plugins import (
    show_backends,
    show_drivers,
    show_kinds,
    show_learners,
    show_modifiers,
    show_sources,
)
from cbdsl.cli.show.policy import show_policy
from cbdsl.cli.show.program import show_program
from cbdsl.cli.show.relations import show_relations
from cbdsl.cli.show.schema import show_schema
from cbdsl.cli.show.shared import show_shared
from cbdsl.cli.show.substitutes import show_substitutes
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.resources import resources
from cbdsl.robot.urdf_reader import read_urdf_if_sound
from cbdsl.types.casts import CASTS
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from cbdsl.types.potential import PotentialType

show = typer.Typer(
    help="Show types, potentials, resources, plug-ins, programs, meshes, and learned knowledge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Robot = Annotated[
    str, typer.Option("--robot", help="Robot: file or name.", autocompletion=names_of("robot"))
]
Like = Annotated[
    str, typer.Option("--like", help="Part of the names to list, such as stereo [all].")
]


@show.command("types")
def show_types(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the types of resources (Table 3.1) and the casts between them."""
    form = read_format(format_, as_json, PLAIN)
    types = [
        {"type": t.name, "space": t.space, "components": t.dimension or "n", "unit": t.unit}
        for t in TYPES.values()
    ]
    casts = [
        {
            "from": cast.source if cast.factors == 1 else f"{cast.source} x {cast.factors}",
            "cast": cast.name,
            "to": cast.target,
            "carries": "values" if cast.value else "displacements",
            "defined by": cast.equation,
        }
        for cast in CASTS
    ]
    if form is Format.JSON:
        print_json({"types": types, "casts": casts})
    else:
        print_table("Types", types)
        print_table("Casts", casts)


@show.command("potentials")
def show_potentials(format_: PlainFormat = "text", as_json: Json = False) -> None:
    """Show the artificial potentials and their conditions of a navigation function."""
    form = read_format(format_, as_json, PLAIN)
    warn_of_faults(POTENTIALS.registry)
    if form is Format.JSON:
        print_json([_potential(potential) for potential in POTENTIALS.values()])
        return
    print_table("Potentials", [_signature(potential) for potential in POTENTIALS.values()])
    rows = [
        {"potential": potential.name, **_navigation(potential)} for potential in POTENTIALS.values()
    ]
    print_table("Conditions of a navigation function", rows)


@show.command("resources")
def show_resources(
    robot: Robot = "dexter", like: Like = "", format_: PlainFormat = "text", as_json: Json = False
) -> None:
    """List the resources that programs can name on a robot."""
    form, library = read_format(format_, as_json, PLAIN), Library()
    file = library.locate(RobotDocument, robot)
    document = library.read(file, RobotDocument).document
    model = read_urdf_if_sound(file.parent / document.model)
    rows = [
        {
            "resource": resource.name,
            "type": str(resource.type),
            "unit": resource.type.unit,
            "origin": resource.origin.value,
            "movable": resource.movable,
        }
        for resource in resources(document, model).values()
        if like in resource.name
    ]
    if not rows:
        raise UsageError(f"--like {like}: no resource of '{document.name}' has this in its name")
    if form is Format.JSON:
        print_json(rows)
    else:
        print_table(f"Resources of {document.name}", rows)


show.command("drivers")(show_drivers)
show.command("sources")(show_sources)
show.command("modifiers")(show_modifiers)
show.command("learners")(show_learners)
show.command("kinds")(show_kinds)
show.command("backends")(show_backends)
show.command("program")(show_program)
show.command("allocations")(show_allocations)
show.command("bindings")(show_bindings)
show.command("substitutes")(show_substitutes)
show.command("policy")(show_policy)
show.command("mesh")(show_mesh)
show.command("schema")(show_schema)
show.command("catalog")(show_catalog)
show.command("knowledge")(show_knowledge)
show.command("meta-catalog")(show_meta_catalog)
show.command("relations")(show_relations)
show.command("shared")(show_shared)


def _signature(potential: PotentialType) -> dict[str, object]:
    return {
        "potential": potential.name,
        "symbol": potential.symbol,
        "defined by": potential.equation,
        "feedback": _accepted(potential),
        "reference": potential.reference,
        "steps by": _step(potential),
        "minimum is 0": potential.zero_minimum,
    }


def _potential(potential: PotentialType) -> dict[str, object]:
    """Return all properties of a potential."""
    types = {"accepts": sorted(potential.accepts), "factors": potential.factors}
    return {**_signature(potential), **types, "navigation": _navigation(potential)}


def _step(potential: PotentialType) -> str:
    if potential.field:
        return "field"
    return "residual" if potential.residual else "gradient"


def _accepted(potential: PotentialType) -> str:
    """Return the types on which a potential is defined, in the order of Table 3.1."""
    several = f" x {potential.factors}" if (potential.factors or 1) > 1 else ""
    return ", ".join(f"{name}{several}" for name in TYPES if name in potential.accepts)


def _navigation(potential: PotentialType) -> dict[str, str]:
    """Return the navigation function conditions of a potential, and their domain."""
    conditions = potential.navigation._asdict()
    domain = conditions.pop("domain")
    return {**{name: str(value) for name, value in conditions.items()}, "for": str(domain)}
