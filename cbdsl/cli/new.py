"""``cb new``: valid documents to start from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from cbdsl.api.propose_robot import propose_robot
from cbdsl.checking.lookup.document_search import for_robot
from cbdsl.cli.output.terminal import print_line, print_problem
from cbdsl.cli.validation import check_paths
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.scaffold.document_template import DocumentTemplate, scalar
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.yaml_text.library import Library

new = typer.Typer(
    help="Write a robot, program or stage to start from.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the document and of its file.")]
Robot = Annotated[str, typer.Option("--robot", help="Robot of the document: file or name.")]
StageRobot = Annotated[
    str | None,
    typer.Option("--robot", help="Robot of the stage: file or name [dexter; any of a scene]."),
]
Mjcf = Annotated[
    Path | None, typer.Option("--mjcf", help="Scene of MuJoCo whose objects the stage takes over.")
]
To = Annotated[
    Path | None,
    typer.Option("--to", help="Folder to write to [the folder of its kind, such as programs]."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file.")]
Renew = Annotated[
    bool,
    typer.Option(
        "--renew", help="Convert a changed model again, and leave the robot's document as it is."
    ),
]
Cameras = Annotated[
    bool,
    typer.Option("--cameras", help="Add two fixed cameras before the arm, to a copy of the model."),
]
Urdf = Annotated[Path, typer.Option("--urdf", help="Model of the robot: URDF, xacro or MJCF.")]
Srdf = Annotated[
    Path | None,
    typer.Option(
        "--srdf", help="SRDF with groups and postures, which become effectors [chains of joints]."
    ),
]
XacroArg = Annotated[
    list[str] | None,
    typer.Option(
        "--xacro-arg", metavar="NAME:=VALUE", help="Argument of a xacro model; may be repeated."
    ),
]
IsXacro = Annotated[
    bool,
    typer.Option("--xacro", help="Read the model as xacro, regardless of the name of its file."),
]
Package = Annotated[
    list[str] | None,
    typer.Option(
        "--package",
        metavar="NAME=FOLDER",
        help="Folder of a ROS package that the model refers to; may be repeated.",
    ),
]


@new.command("program")
def new_program(name: Name, robot: Robot = "dexter", to: To = None, force: Force = False) -> None:
    """Write a program that moves an effector to a posture."""
    body = _robot(robot)
    effector, posture = _posture(body)
    values = {"robot": body.name, "effector": effector, "posture": posture, "stage": _stage(body)}
    _write(DocumentTemplate(ProgramDocument, "program", name, to), values, force)


@new.command("robot")
def new_robot(
    name: Name,
    urdf: Urdf,
    *,
    srdf: Srdf = None,
    xacro_arg: XacroArg = None,
    xacro: IsXacro = False,
    package: Package = None,
    to: To = None,
    force: Force = False,
    renew: Renew = False,
    cameras: Cameras = False,
) -> None:
    """Write a robot for a model in URDF, xacro or MJCF.

    Chains of joints, or the groups of --srdf, become effectors with a tip, a posture, and their
    limits as comments. For other formats than URDF, a URDF is written beside the robot (extra
    formats).
    """
    proposal = propose_robot(
        name,
        urdf,
        srdf=srdf,
        xacro=xacro,
        xacro_arguments=xacro_arg or (),
        packages=package or (),
        to=to,
        force=force,
        renew=renew,
        cameras=cameras,
    )
    _conclude(proposal.robot, proposal.files, proposal.remarks)


@new.command("stage")
def new_stage(
    name: Name, robot: StageRobot = None, mjcf: Mjcf = None, to: To = None, force: Force = False
) -> None:
    """Write a stage with a ball on a table within the robot's reach, or that of a MuJoCo scene.

    Fixed bodies of the scene become fixtures, and free ones things at their places; several
    keyframes give ranges of places. Parts that no stage can state are named (extra formats).
    """
    from cbdsl.kinematics.bench import bench

    if mjcf is not None:
        _new_scene(name, mjcf, ANY_ROBOT if robot is None else _robot(robot).name, to, force)
    body, file = _located(robot or "dexter")
    values = {"robot": body.name, **bench(body, file).values()}
    _write(DocumentTemplate(StageDocument, "stage", name, to), values, force)


def _new_scene(name: str, mjcf: Path, robot: str, to: Path | None, force: bool) -> NoReturn:
    """Write the stage of a MuJoCo scene, and check it."""
    from cbdsl.robot.package_folders import PackageFolders
    from cbdsl.robot.urdf import UrdfError
    from cbdsl.scaffold.model_format import SCENE_FORMATS

    template = DocumentTemplate(StageDocument, "stage", name, to, "scene")
    try:
        scene = SCENE_FORMATS.get("mjcf").converted(mjcf, name, {}, PackageFolders({}, [], mjcf))
    except UrdfError as error:
        raise UsageError(str(error)) from error
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{mjcf}: {error.name} is not installed: pip install 'cbdsl[formats]'"
        ) from None
    files = {template.folder / file: contents for file, contents in scene.meshes.items()}
    description = scalar(f"The scene {mjcf.name}.")
    values = {"robot": robot, "description": description, "parts": scene.text}
    written = template.write(values, force, files)
    _conclude(template.file, [*files, *written], scene.remarks)


def _robot(name: str) -> RobotDocument:
    return _located(name)[0]


def _located(name: str) -> tuple[RobotDocument, Path]:
    """Return a robot's document, and its file."""
    library = Library()
    file = library.locate(RobotDocument, name)
    return library.read(file, RobotDocument).document, file


def _posture(robot: RobotDocument) -> tuple[str, str]:
    """Return an effector and one of its postures, preferably not its start posture."""
    candidates = [
        (posture == effector.start, name, posture)
        for name, effector in robot.effectors.items()
        for posture in effector.postures
    ]
    if not candidates:
        raise UsageError(f"robot '{robot.name}' has no postures; give one of its effectors one")
    # False sorts before True. A program to the start posture would be at rest immediately.
    _, name, posture = min(candidates, key=lambda candidate: candidate[0])
    return name, posture


def _stage(robot: RobotDocument) -> str:
    """Return the line of a program that names a stage of its robot, or a comment."""
    names = for_robot(StageDocument, robot.name, None, Library(), others=())
    if names:
        return f"stage: {names[0]}"
    return f"# stage: one of {robot.name}'s, such as cb new stage NAME --robot {robot.name} writes"


def _write(template: DocumentTemplate, values: Mapping[str, str], force: bool) -> NoReturn:
    """Write a document and check it."""
    written = template.write(values, force)
    _conclude(template.file, written)


def _conclude(file: Path, written: Sequence[Path], remarks: Sequence[str] = ()) -> NoReturn:
    """Print the written files and remarks, and check the document."""
    for path in written:
        print_line(f"wrote {path}")
    for remark in remarks:
        print_problem(remark)
    raise typer.Exit(check_paths([str(file)], {}))
