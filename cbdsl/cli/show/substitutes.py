"""``cb show substitutes``: programs that can replace a program, or a part of it."""

from __future__ import annotations

from cbdsl.checking.program import check_program
from cbdsl.checking.session import Session
from cbdsl.checking.stand_ins import stand_ins_of
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import ShownProgram, With
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.documents.program import ProgramDocument


def show_substitutes(
    name: ShownProgram,
    with_: With = [],  # noqa: B006 (typer)
    format_: PlainFormat = "text",
    as_json: Json = False,
) -> None:
    """Show programs with the same reward as a program, or as one of its members.

    The types of signals and effectors and the reward are compared, and names are ignored.
    """
    form = read_format(format_, as_json, PLAIN)
    session, values = Session(), read_assignments(with_)
    # Errors of the program itself are reported before anything is compared with it.
    check_program(name, values, session.library)
    path = session.library.locate(ProgramDocument, name)
    rows = [
        {
            "in place of": each.member,
            "program": each.program,
            "rewarded for": str(each.kind),
        }
        for each in stand_ins_of(path, session, values)
    ]
    if form is Format.JSON:
        print_json(rows)
    elif not rows:
        print(f"no program is rewarded for what {path.stem} is rewarded for")
    else:
        print_table(f"Substitutes in {path.stem}", rows)
