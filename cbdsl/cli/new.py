"""``cb new``: documents to start from, valid as they are written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from cbdsl.documents.document import Document
    from cbdsl.documents.robot import RobotDocument

new = typer.Typer(
    help="Write a robot, program or stage to start from.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Name = Annotated[str, typer.Argument(metavar="NAME", help="Its name, and that of its file.")]
Robot = Annotated[str, typer.Option("--robot", help="Name or file of the robot that it is for.")]
To = Annotated[
    Path | None,
    typer.Option("--to", help="Folder to write to [where names are looked up, such as programs]."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace a file that is there.")]
Urdf = Annotated[Path, typer.Option("--urdf", help="The robot's model.")]


@new.command("program")
def new_program(name: Name, robot: Robot = "dexter", to: To = None, force: Force = False) -> None:
    """A program: an effector moves to a posture."""
    from cbdsl.documents.program import ProgramDocument

    body = _robot(robot)
    effector, posture = _posture(body)
    values = {"robot": body.name, "effector": effector, "posture": posture, "stage": _stage(body)}
    _write(ProgramDocument, "program", name, values, to, force)


@new.command("robot")
def new_robot(name: Name, urdf: Urdf, to: To = None, force: Force = False) -> None:
    """A robot, from its URDF.

    Rows of joints become effectors, with a tip, a posture and the limits as comments.
    """
    from cbdsl.cli.proposal import propose
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.errors.errors import UsageError
    from cbdsl.robot.urdf import UrdfError
    from cbdsl.robot.urdf_reader import read_urdf

    try:
        model = read_urdf(urdf)
    except UrdfError as error:
        raise UsageError(f"--urdf {error}") from None
    proposal = propose(model, _folder(RobotDocument, to))
    _write(RobotDocument, "robot", name, proposal.values, to, force, proposal.left_out)


@new.command("stage")
def new_stage(name: Name, robot: Robot = "dexter", to: To = None, force: Force = False) -> None:
    """A stage: a ball on a table, or nothing."""
    from cbdsl.documents.stage import StageDocument

    _write(StageDocument, "stage", name, {"robot": _robot(robot).name}, to, force)


def _robot(name: str) -> RobotDocument:
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    library = Library()
    return library.read(library.locate(RobotDocument, name), RobotDocument).document


def _posture(robot: RobotDocument) -> tuple[str, str]:
    """An effector and a posture of it: one where it does not start, if there is one."""
    from cbdsl.errors.errors import UsageError

    candidates = [
        (posture == effector.start, name, posture)
        for name, effector in robot.effectors.items()
        for posture in effector.postures
    ]
    if not candidates:
        raise UsageError(f"robot '{robot.name}' has no postures; give one of its effectors one")
    _, name, posture = min(candidates, key=lambda candidate: candidate[0])
    return name, posture


def _stage(robot: RobotDocument) -> str:
    """The line of a program that names a stage of its robot, if there is one."""
    from cbdsl.checking.lookup.documents import for_robot
    from cbdsl.documents.stage import StageDocument
    from cbdsl.yaml_text.library import Library

    names = for_robot(StageDocument, robot.name, None, Library())
    if names:
        return f"stage: {names[0]}"
    return f"# stage: one of {robot.name}'s, such as cb new stage NAME --robot {robot.name} writes"


def _folder(kind: type[Document], to: Path | None) -> Path:
    from cbdsl.documents.kinds import kind_of

    return Path(kind_of(kind).folder) if to is None else to


def _write(
    kind: type[Document],
    word: str,
    name: str,
    values: dict[str, str],
    to: Path | None,
    force: bool,
    left_out: str = "",
) -> None:
    """Fill a template in, write it where it belongs, and check what was written.

    What was ``left_out`` of it, if anything, is told.
    """
    from string import Template

    from cbdsl.cli.findings import check_paths
    from cbdsl.cli.terminal import print_problem
    from cbdsl.errors.errors import UsageError
    from cbdsl.errors.reason import reason
    from cbdsl.yaml_text.writer import write_text

    _require_name(name)
    folder = _folder(kind, to)
    file = folder / f"{name}.yaml"
    if file.exists() and not force:
        raise UsageError(f"{file} is there; --force replaces it")
    template = Path(__file__).parent / "templates" / f"{word}.yaml.template"
    text = Template(template.read_text("utf-8"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        filled = text.substitute(values, name=name, schema=_schema(word, folder))
        write_text(filled, file)
    except OSError as error:
        raise UsageError(f"{file}: {reason(error)}") from error
    print(f"wrote {file}", flush=True)
    if left_out:
        print_problem(f"left out what programs cannot move: {left_out}; its comments say more")
    raise typer.Exit(check_paths([str(file)], {}))


def _require_name(name: str) -> None:
    import re

    from cbdsl.documents.document import NAME_PATTERN
    from cbdsl.errors.errors import UsageError

    if not re.search(NAME_PATTERN, name):
        raise UsageError(
            f"'{name}' is no name: a letter, then letters, digits and underscores make one"
        )


def _schema(word: str, folder: Path) -> str:
    """The path of a kind's schema from a folder: the nearest above it, or the shipped one."""
    import os

    from cbdsl.documents.json_schema import schema_file
    from cbdsl.yaml_text.library import shipped

    here = folder.resolve()
    roots = (*here.parents, shipped())
    files = (root / "schemas" / schema_file(word) for root in roots)
    nearest = next((file for file in files if file.is_file()), None)
    target = nearest or shipped() / "schemas" / schema_file(word)
    return Path(os.path.relpath(target, here)).as_posix()
