"""``cb new``: valid documents to start from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

if TYPE_CHECKING:
    from cbdsl.cli.model_source import ModelReader
    from cbdsl.documents.document import Document
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.robot.semantic_groups import SemanticGroups
    from cbdsl.robot.urdf import UrdfModel

new = typer.Typer(
    help="Write a robot, program or stage to start from.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the document and of its file.")]
Robot = Annotated[str, typer.Option("--robot", help="Robot of the document: file or name.")]
To = Annotated[
    Path | None,
    typer.Option("--to", help="Folder to write to [the folder of its kind, such as programs]."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file.")]
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
    from cbdsl.documents.program import ProgramDocument

    body = _robot(robot)
    effector, posture = _posture(body)
    values = {"robot": body.name, "effector": effector, "posture": posture, "stage": _stage(body)}
    _Template(ProgramDocument, "program", name, to).write(values, force)


@new.command("robot")
def new_robot(
    name: Name,
    urdf: Urdf,
    srdf: Srdf = None,
    xacro_arg: XacroArg = None,
    xacro: IsXacro = False,
    package: Package = None,
    to: To = None,
    force: Force = False,
) -> None:
    """Write a robot for a model in URDF, xacro or MJCF.

    Chains of joints, or the groups of --srdf, become effectors with a tip, a posture, and their
    limits as comments. For other formats than URDF, a URDF is written beside the robot (extra
    formats).
    """
    from cbdsl.cli.model_source import ModelReader
    from cbdsl.cli.proposal import propose
    from cbdsl.documents.robot import RobotDocument

    _require_name(name)
    folder = _folder(RobotDocument, to)
    reader = ModelReader(urdf, xacro_arg or (), package or (), xacro)
    source = reader.read(name, folder)
    semantics = None if srdf is None else _semantics(reader, srdf, source.model)
    proposal = propose(source.model, folder, semantics)
    remarks = [*source.remarks, *([] if semantics is None else semantics.remarks)]
    if proposal.left_out:
        counts = proposal.left_out
        remarks.append(
            f"left out joints that programs cannot move: {counts}; the document lists them"
        )
    remarks += proposal.remarks
    template = _Template(RobotDocument, "robot", name, to)
    template.write(proposal.values, force, source.files, remarks)


def _semantics(reader: ModelReader, srdf: Path, model: UrdfModel) -> SemanticGroups:
    from cbdsl.errors.errors import UsageError
    from cbdsl.robot.semantic_groups import SemanticGroups
    from cbdsl.robot.urdf import UrdfError

    description = reader.semantics(srdf)
    try:
        return SemanticGroups(model, description)
    except UrdfError as error:
        raise UsageError(f"--srdf {error}") from None


@new.command("stage")
def new_stage(name: Name, robot: Robot = "dexter", to: To = None, force: Force = False) -> None:
    """Write a stage with a ball on a table within the robot's reach, or an empty one."""
    from cbdsl.cli.bench import bench
    from cbdsl.documents.stage import StageDocument

    body, file = _located(robot)
    values = {"robot": body.name, **bench(body, file).values()}
    _Template(StageDocument, "stage", name, to).write(values, force)


def _robot(name: str) -> RobotDocument:
    return _located(name)[0]


def _located(name: str) -> tuple[RobotDocument, Path]:
    """Return a robot's document, and its file."""
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.yaml_text.library import Library

    library = Library()
    file = library.locate(RobotDocument, name)
    return library.read(file, RobotDocument).document, file


def _posture(robot: RobotDocument) -> tuple[str, str]:
    """Return an effector and one of its postures, preferably not its start posture."""
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
    """Return the line of a program that names a stage of its robot, or a comment."""
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


class _Template:
    """Template of a document.

    Args:
        kind: Kind of document.
        word: Name of the kind and of its template.
        name: Name of the document.
        to: Folder of the document; ``None`` for the kind's folder.

    Raises:
        UsageError: The name is invalid.
    """

    def __init__(self, kind: type[Document], word: str, name: str, to: Path | None) -> None:
        _require_name(name)
        self._word, self._name = word, name
        self._folder = _folder(kind, to)
        # Folder of the document's project, as far as known.
        self._root = Path() if to is None else self._folder

    def write(
        self,
        values: Mapping[str, str],
        force: bool,
        files: Mapping[Path, bytes] = MappingProxyType({}),
        remarks: Sequence[str] = (),
    ) -> NoReturn:
        """Write the document to its folder, with the files that it needs, and check it.

        Args:
            values: Values of the template's placeholders.
            force: True to replace existing files.
            files: Contents of the files to which the document refers, by path.
            remarks: Sentences about contents that the document lacks.

        Raises:
            UsageError: A file exists already, or cannot be written.
        """
        import os
        from string import Template

        from cbdsl.cli.findings import check_paths
        from cbdsl.cli.terminal import print_problem
        from cbdsl.errors.errors import UsageError
        from cbdsl.errors.reason import reason
        from cbdsl.yaml_text.writer import write_bytes, write_text

        file = self._folder / f"{self._name}.yaml"
        there = next((each for each in (file, *files) if each.exists() and not force), None)
        if there is not None:
            raise UsageError(f"{there} is there; --force replaces it")
        template = Path(__file__).parent / "templates" / f"{self._word}.yaml.template"
        text = Template(template.read_text("utf-8"))
        schema, generated = _schema(self._word, self._folder, self._root)
        line = Path(os.path.relpath(schema, self._folder)).as_posix()
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            for path, contents in {**files, **generated}.items():
                path.parent.mkdir(parents=True, exist_ok=True)
                write_bytes(contents, path)
            write_text(text.substitute(values, name=self._name, schema=line), file)
        except OSError as error:
            raise UsageError(f"{file}: {reason(error)}") from error
        for path in (*(each for each in files if each.suffix == ".urdf"), *generated, file):
            print(f"wrote {path}", flush=True)
        for remark in remarks:
            print_problem(remark)
        # Assumptions about the robot were reported when its document was written.
        raise typer.Exit(check_paths([str(file)], {}, notes_elsewhere=False))


def _require_name(name: str) -> None:
    import re

    from cbdsl.documents.document import NAME_PATTERN
    from cbdsl.errors.errors import UsageError

    if not re.search(NAME_PATTERN, name):
        raise UsageError(
            f"'{name}' is not a name: a letter, then letters, digits and underscores make one"
        )


def _schema(word: str, folder: Path, root: Path) -> tuple[Path, dict[Path, bytes]]:
    """Return the schema of a kind for documents of a folder, and the file to write for it.

    The file is that of the nearest folder ``schemas`` above the documents. Where there is none, it
    is written to the project, since a path into the installed package would be wrong elsewhere.

    Args:
        word: Name of the kind.
        folder: Folder of the document.
        root: Folder of its project.
    """
    from cbdsl.documents.json_schema import json_schema, json_text, schema_file
    from cbdsl.documents.kinds import KINDS

    here, file = folder.resolve(), Path("schemas") / schema_file(word)
    nearest = next(
        (above / file for above in (here, *here.parents) if (above / file).is_file()), None
    )
    if nearest is not None:
        return nearest, {}
    text = json_text(json_schema(KINDS.get(word).model))
    return root / file, {root / file: text.encode()}
