"""``cb show bindings``: effectors of a robot in the roles of a program."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.checking.rules.roles import Binding, bind, bindings, read_roles
from cbdsl.checking.session import Session
from cbdsl.cli.arguments.options import Robot, ShownProgram
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.loaded import Loaded


def show_bindings(
    name: ShownProgram,
    robot: Robot = None,
    format_: PlainFormat = "text",
    as_json: Json = False,
) -> None:
    """Show which effectors may be in the roles of a program, and the reasons against others."""
    form, session = read_format(format_, as_json, PLAIN), Session()
    path = session.library.locate(ProgramDocument, name)
    loaded = session.library.read_as_written(path, ProgramDocument)
    roles = loaded.document.roles
    if not roles:
        print(f"{path.stem} is for robot '{loaded.document.robot}' alone: it has no 'roles'")
        return
    names = [robot] if robot else session.library.names(RobotDocument, path)
    rows = [row for each in names for row in _rows(loaded, each, session)]
    if form is Format.JSON:
        print_json(rows)
        return
    columns = ("robot", *roles, "fits", "chosen")
    print_table(f"Bindings of {path.stem}", [{c: row.get(c, "") for c in columns} for row in rows])


def _rows(
    loaded: Loaded[ProgramDocument], robot: str, session: Session
) -> Iterator[dict[str, str]]:
    """Yield a robot's choices of effectors, or the reason why it has none."""
    file = session.library.find(RobotDocument, robot, loaded.path)
    body = session.body(file or UNKNOWN, Diagnostics())
    if isinstance(body, Unknown):
        problem = f"cb validate {file} tells its errors" if file else "there is no such robot"
        yield {"robot": robot, "fits": problem}
        return
    bound = bind(loaded, body, session.values)
    is_bound = isinstance(bound, Loaded)
    chosen = bound.document.parameters if isinstance(bound, Loaded) else {}
    none = Binding({}, "" if is_bound else str(bound))
    for each in list(bindings(read_roles(loaded.document), body, session.values)) or [none]:
        is_chosen = is_bound and each.effectors.items() <= chosen.items()
        yield {
            "robot": robot,
            **each.effectors,
            "fits": each.refusal or "yes",
            "chosen": "yes" if is_chosen else "",
        }
