"""``cb show allocations``: resources with which a program can run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cbdsl.checking.allocations import allocations
from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import Robot, ShownProgram, With
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.documents.program import ProgramDocument

if TYPE_CHECKING:
    from cbdsl.checking.substitution import Allocation


def show_allocations(
    name: ShownProgram,
    with_: With = [],  # noqa: B006 (typer)
    robot: Robot = None,
    format_: PlainFormat = "text",
    as_json: Json = False,
) -> None:
    """Show the possible resources of a program's parameters, and the reasons against others.

    All combinations for the section resources are checked as separate programs.
    """
    form = read_format(format_, as_json, PLAIN)
    session, values = Session(), read_assignments(with_, robot=robot)
    # Errors of the program itself come first: all of its allocations would repeat them.
    check_program(name, values, session.library)
    path = session.library.locate(ProgramDocument, name)
    combinations = sorted(allocations(path, session, values), key=lambda each: bool(each.refusal))
    if form is Format.JSON:
        print_json([_data(each) for each in combinations])
    elif not session.library.read(path, ProgramDocument).document.resources:
        print(f"{path.stem} lets no parameter stand for another resource: it has no 'resources'")
    else:
        columns = dict.fromkeys(key for each in combinations for key in each.values)
        rows = [
            {**{key: each.values.get(key, "") for key in columns}, "fits": _verdict(each)}
            for each in combinations
        ]
        print_table(f"Allocations of {path.stem}", rows)


def _verdict(allocation: Allocation) -> str:
    return allocation.refusal or "yes"


def _data(allocation: Allocation) -> dict[str, object]:
    return {
        "values": dict(allocation.values),
        "fits": not allocation.refusal,
        "refusal": allocation.refusal or None,
    }
