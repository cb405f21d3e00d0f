"""``cb show``: types, resources and programs as the checker sees them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from cbdsl.program.checked import Action, CheckedProgram
    from cbdsl.program.controller import Controller, Reference

show = typer.Typer(
    help="Show types, resources and programs.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Robot = Annotated[str, typer.Option("--robot", help="Name or file of a robot document.")]
Program = Annotated[str, typer.Argument(metavar="NAME", help="Name or file of a program.")]
With = Annotated[list[str], typer.Option("--with", help="A parameter, as name=value.")]


@show.command("types")
def show_types(as_json: Json = False) -> None:
    """The types of resources (Table 3.1) and the casts between them."""
    from cbdsl.cli.terminal import print_json, print_table
    from cbdsl.types.casts import CASTS
    from cbdsl.types.resource_type import TYPES

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
    if as_json:
        print_json({"types": types, "casts": casts})
    else:
        print_table("Types", types)
        print_table("Casts", casts)


@show.command("resources")
def show_resources(robot: Robot = "dexter", as_json: Json = False) -> None:
    """What programs can name on a robot."""
    from cbdsl.cli.terminal import print_json, print_table
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.robot.resources import resources
    from cbdsl.yaml_text.library import Library

    library = Library()
    document = library.read(library.locate(RobotDocument, robot), RobotDocument).document
    rows = [
        {
            "resource": resource.name,
            "type": str(resource.type),
            "unit": resource.type.unit,
            "origin": resource.origin.value,
            "movable": resource.movable,
        }
        for resource in resources(document).values()
    ]
    if as_json:
        print_json(rows)
    else:
        print_table(f"Resources of {document.name}", rows)


@show.command("program")
def show_program(name: Program, with_: With = [], as_json: Json = False) -> None:  # noqa: B006 (typer)
    """A program's controllers, actions and policy, with everything resolved."""
    from cbdsl.checking.program import check_program
    from cbdsl.cli.assignments import read_assignments
    from cbdsl.cli.terminal import print_json, print_table

    program = check_program(name, read_assignments(with_))
    data = _program(program)
    if as_json:
        print_json(data)
        return
    print(f"{program.name} on {program.robot}, stage {program.stage or 'none'}")
    print("parameters:", _pairs(program.parameters) or "none")
    print("state:", ", ".join(program.members))
    print_table("Controllers", [_row(c) for c in _controllers(program)])
    print_table("Actions, highest priority first", [_action_row(a) for a in program.actions])
    if program.background is not None:
        print("below every action:", program.background)
    policy = [{"state": state, "action": action} for state, action in program.policy.items()]
    print_table("Policy", policy)


def _program(program: CheckedProgram) -> dict[str, object]:
    return {
        "name": program.name,
        "robot": program.robot,
        "stage": program.stage,
        "parameters": dict(program.parameters),
        "state": list(program.members),
        "controllers": [_row(controller) for controller in _controllers(program)],
        "actions": [
            {**_action_row(a), "uses": _program(a.program) if a.program else None}
            for a in program.actions
        ],
        "background": str(program.background) if program.background else None,
        "policy": dict(program.policy),
    }


def _controllers(program: CheckedProgram) -> Sequence[Controller]:
    """All controllers of a program, each once."""
    stacks = [a.composition for a in program.actions if a.composition is not None]
    if program.background is not None:
        stacks.append(program.background)
    found = {c.name: c for s in stacks for p in s.primitives for c in p.controllers}
    return list(found.values())


def _row(controller: Controller) -> dict[str, object]:
    return {
        "controller": controller.name,
        "potential": controller.potential,
        "feedback": controller.feedback.name,
        "reference": _reference(controller.reference),
        "effector": controller.effector.name,
        "casts": " → ".join(controller.chain),
        "gain": f"{controller.gain:g} /s",
        "rewarded": controller.rewarded,
    }


def _action_row(action: Action) -> dict[str, object]:
    if action.composition is None:
        return {"action": action.name, "runs": "the program of this name"}
    stack = [
        controller.name
        for primitive in reversed(action.composition.primitives)
        for controller in reversed(primitive.controllers)
    ]
    return {"action": action.name, "runs": " > ".join(stack)}


def _reference(reference: Reference | None) -> str:
    from cbdsl.program.controller import AlongNormals, Literal

    if reference is None:
        return "none"
    if isinstance(reference, Literal):
        return f"[{', '.join(f'{value:g}' for value in reference.values)}]"
    if isinstance(reference, AlongNormals):
        return f"{reference.force:g} N along normals"
    return reference.name


def _pairs(values: Mapping[str, str]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())
