"""``cb show program``: a program before it runs, as text, as data, or as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.checking.program import check_program
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import Robot, ShownProgram, With
from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import Format, Json, drawing, read_format
from cbdsl.program.dry_run import controllers, coverage, levels, resources, rewarding
from cbdsl.reporting.automaton_text import automata, automaton_data
from cbdsl.reporting.drawing.automaton_graph import automaton_graph
from cbdsl.reporting.text.program_text import casts_text, claims, program_text, reference_text

if TYPE_CHECKING:
    from cbdsl.program.checked import Action, CheckedProgram
    from cbdsl.program.controller import Controller

FormatOption = Annotated[
    str,
    typer.Option(
        "--format",
        help="Output format: text or json; dot, mermaid or svg for a graph of the steps.",
    ),
]


def show_program(
    name: ShownProgram,
    with_: With = [],  # noqa: B006 (typer)
    robot: Robot = None,
    format_: FormatOption = "text",
    as_json: Json = False,
) -> None:
    """Show a program with all names, casts and parameters resolved.

    The text has the controllers with their casts, the levels and free directions of each action,
    possible rewards, and the policy. The formats dot, mermaid and svg draw its steps.
    """
    form = read_format(format_, as_json)
    program = check_program(name, read_assignments(with_, robot=robot))
    if form is Format.JSON:
        print_json(program_data(program))
    elif form is Format.TEXT:
        print(program_text(program), end="")
    else:
        print(drawing(automaton_graph(program.name, automata(program)), form), end="")


def program_data(program: CheckedProgram) -> dict[str, object]:
    """Return a program as data of JSON, with the programs that it uses."""
    shares = coverage(program)
    return {
        "name": program.name,
        "robot": program.robot,
        "stage": program.stage,
        "parameters": dict(program.parameters),
        "state": list(program.members),
        "conditions": {each.name: each.text for each in program.conditions.values()},
        "limits": {
            "transitions": program.transitions,
            "transition_time": program.transition_time,
            "idle_time": program.idle_time,
        },
        "claims": claims(program),
        "resources": [
            {"resource": r.name, "type": str(r.type), "unit": r.type.unit, "origin": r.origin.value}
            for r in resources(program)
        ],
        "controllers": [_controller(controller) for controller in controllers(program)],
        "actions": [_action(program, action) for action in program.actions],
        "background": str(program.background) if program.background else None,
        "policy": dict(program.policy),
        "automaton": automaton_data(program),
        "states": {
            "all": shares.states,
            "decided": dict(shares.decided),
            "undecided": shares.undecided,
        },
    }


def _controller(controller: Controller) -> dict[str, object]:
    return {
        "controller": controller.name,
        "potential": controller.potential,
        "feedback": controller.feedback.name,
        "type": str(controller.feedback.type),
        "reference": reference_text(controller.reference, controller.compared.unit),
        "effector": controller.effector.name,
        "joints": list(controller.joints),
        "casts": casts_text(controller),
        "gain": f"{controller.gain:g} /s",
        "requires": controller.requires,
        "rewarded": controller.rewarded,
    }


def _action(program: CheckedProgram, action: Action) -> dict[str, object]:
    stack = levels(program, action)
    runs = " > ".join(level.controller.name for level in stack if not level.background)
    return {
        "action": action.name,
        "runs": runs or "the program of this name",
        "levels": [
            {
                "controller": level.controller.name,
                "background": level.background,
                "joints": len(level.controller.joints),
                "rows_at_most": level.rows,
                "free_at_least": level.free,
            }
            for level in stack
        ],
        "rewarding": list(rewarding(action)),
        "uses": program_data(action.program) if action.program else None,
    }
