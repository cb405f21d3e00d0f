"""``cb show bindings``: effectors of a robot in the roles of a program."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.checking.robot.role_effectors import Binding, bindings
from cbdsl.checking.roles import check_roles, on_robot, roles_on
from cbdsl.checking.session import Session
from cbdsl.cli.arguments.options import Robot, ShownProgram
from cbdsl.cli.output.terminal import print_json, print_table
from cbdsl.cli.show.formats import PLAIN, Format, Json, PlainFormat, read_format
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.reader import flawless


def show_bindings(
    name: ShownProgram, robot: Robot = None, format_: PlainFormat = "text", as_json: Json = False
) -> None:
    """Show which effectors may be in the roles of a program, and the reasons against others."""
    form, session = read_format(format_, as_json, PLAIN), Session()
    path = session.library.locate(ProgramDocument, name)
    loaded = flawless(session.library.read_as_written(path, ProgramDocument))
    roles = loaded.document.roles
    if not roles:
        print(f"{path.stem} is for robot '{loaded.document.robot}' alone: it has no 'roles'")
        return
    diagnostics = Diagnostics()
    check_roles(loaded, diagnostics)
    if diagnostics.failed:
        raise DiagnosticsError(diagnostics.sorted())
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
    bound = on_robot(robot, loaded, session.values, session)
    chosen = bound.document.parameters if isinstance(bound, Loaded) else None
    file = session.library.find(RobotDocument, robot, loaded.path)
    body = session.body(file or UNKNOWN, Diagnostics())
    every = list[Binding]()
    if not isinstance(body, Unknown):
        every = list(bindings(roles_on(body, loaded.document, {}), body, {}))
    for each in every or [Binding({}, str(bound))]:
        refusal = each.refusal or (bound if isinstance(bound, str) else "")
        # Eyes are no parameters.
        is_chosen = chosen is not None and all(
            chosen.get(role, value) == value for role, value in each.effectors.items()
        )
        yield {
            "robot": robot,
            **each.effectors,
            "fits": refusal or "yes",
            "chosen": "yes" if is_chosen else "",
        }
