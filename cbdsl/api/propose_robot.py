"""``cbdsl.propose_robot``: a robot document for a model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.robot.semantic_groups import SemanticGroups
    from cbdsl.robot.urdf import UrdfModel
    from cbdsl.scaffold.model_source import ModelReader


@dataclass(frozen=True)
class RobotProposal:
    """Written robot document.

    Attributes:
        robot: File of the robot document.
        files: All written files: URDF, JSON Schema and robot.
        remarks: Sentences about parts of the model that the document leaves out.
    """

    robot: Path
    files: tuple[Path, ...]
    remarks: tuple[str, ...]


def propose_robot(
    name: str,
    model: str | Path,
    *,
    srdf: str | Path | None = None,
    xacro: bool = False,
    xacro_arguments: Sequence[str] = (),
    packages: Sequence[str] = (),
    to: str | Path | None = None,
    force: bool = False,
    renew: bool = False,
    cameras: bool = False,
) -> RobotProposal:
    """Write a robot document for a model in URDF, xacro or MJCF.

    Chains of joints, or the groups of an SRDF, become effectors with a tip, a posture, and their
    limits as comments. ``check`` reports open points of the document.

    Args:
        name: Name of the robot and of its file.
        model: File of the model.
        srdf: File with groups and postures, which become effectors; chains of joints if ``None``.
        xacro: True to read the model as xacro, regardless of the name of its file.
        xacro_arguments: Arguments of a xacro model, each ``NAME:=VALUE``.
        packages: Folders of ROS packages that the model refers to, each ``NAME=FOLDER``.
        to: Folder of the document; ``robots`` if ``None``.
        force: True to replace existing files.
        renew: True to convert the model again for a robot document, which stays as it is.
        cameras: True to add two fixed cameras that look at a bench before the robot, to a copy of
            the model.

    Raises:
        UsageError: The model cannot be read, has no movable joint, or a file exists already; with
            ``renew``, the document is missing.
    """
    from cbdsl.documents.robot import RobotDocument
    from cbdsl.scaffold.document_template import DocumentTemplate
    from cbdsl.scaffold.model_source import ModelReader
    from cbdsl.scaffold.proposal import propose

    template = DocumentTemplate(RobotDocument, "robot", name, None if to is None else Path(to))
    reader = ModelReader(Path(model), xacro_arguments, packages, xacro)
    source = reader.read(name, template.folder)
    if renew:
        written = _models(template.renew(source.files))
        return RobotProposal(template.file, written, source.remarks)
    semantics = None if srdf is None else _semantics(reader, Path(srdf), source.model)
    proposal = propose(source.model, template.folder, semantics)
    remarks = [*source.remarks, *([] if semantics is None else semantics.remarks)]
    if proposal.left_out:
        counts = proposal.left_out
        remarks.append(f"left out what programs cannot move: {counts}; its comments say more")
    remarks += proposal.remarks
    written = template.write(proposal.values, force, source.files)
    models = _models(source.files)
    if cameras:
        from cbdsl.scaffold.eyes import add_eyes

        models = (add_eyes(template.file),)
    return RobotProposal(template.file, (*models, *written), tuple(remarks))


def _models(files: Iterable[Path]) -> tuple[Path, ...]:
    """Return the models among files; their meshes are not worth a line each."""
    return tuple(path for path in files if path.suffix == ".urdf")


def _semantics(reader: ModelReader, srdf: Path, model: UrdfModel) -> SemanticGroups:
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.robot.semantic_groups import SemanticGroups
    from cbdsl.robot.urdf import UrdfError

    description = reader.semantics(srdf)
    try:
        return SemanticGroups(model, description)
    except UrdfError as error:
        raise UsageError(f"srdf {error}") from None
