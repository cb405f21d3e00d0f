"""Learned policies, their internal models and their journals, read from files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cbdsl.api.documents import (
    Curve,
    ModelDocument,
    PolicyDocument,
    ProgramDocument,
    RobotDocument,
    digest_of_bytes,
)
from cbdsl.api.drawing import require_legible
from cbdsl.api.learning import Experience
from cbdsl.api.trials import EPISODES
from cbdsl.extend.backend import read_urdf
from cbdsl.extend.command import MOST_BYTES, DiagnosticsError, UsageError, count, reason, rows_of
from cbdsl.extend.document import Library, is_of
from cbdsl.extend.driver import UrdfError
from cbdsl.extend.model import contents

_JOURNAL = ".episodes.jsonl"


class Joint(NamedTuple):
    """Joint of an internal model.

    Attributes:
        name: Name of the joint.
        lower, upper: Limits of the joint, rad or m.
        unit: Unit of its position, rad or m.
    """

    name: str
    lower: float
    upper: float
    unit: str = "rad"

    @property
    def is_endless(self) -> bool:
        """True if it turns without limits."""
        return self.unit == "rad" and math.isinf(self.upper - self.lower)


class InternalModel(NamedTuple):
    """Internal model of a learned policy.

    Attributes:
        name: Name in the program, or ``None`` if the program draws nothing from it.
        document: Document with the density.
        joints: Joints of its angles, in order.
    """

    name: str | None
    document: ModelDocument
    joints: tuple[Joint, ...]


@dataclass(frozen=True)
class Learned:
    """Learned policy, with its models and episodes.

    Attributes:
        file: File of the policy.
        sha256: SHA-256 of the file's content.
        policy: Document of the policy.
        programs: Names of the programs among its members.
        models: Internal models of the policy.
        curve: Learning curve of the policy.
        experiences: Episodes of the journal beside it; empty without a journal.
        notes: Sentences about missing parts.
    """

    file: Path
    sha256: str
    policy: PolicyDocument
    programs: frozenset[str]
    models: tuple[InternalModel, ...]
    curve: Curve
    experiences: tuple[Experience, ...]
    notes: tuple[str, ...]


def find_learned(path: Path) -> list[Path]:
    """Return the file of a policy, or the files of all policies in a folder.

    Raises:
        UsageError: There is none.
    """
    if not path.exists():
        raise UsageError(f"{path}: there is no such file or folder")
    if not path.is_dir():
        if path.name.endswith(_JOURNAL):
            policy = path.with_name(path.name.removesuffix(_JOURNAL) + ".yaml")
            raise UsageError(f"{path}: a journal; name the policy that was learned, {policy}")
        return [path]
    files = [each for each in path.glob("*.yaml") if is_of(PolicyDocument, each)]
    if not files:
        raise UsageError(
            f"{path}: no policy is in this folder; cb learn --out writes one when a trial is over"
        )
    return sorted(files, key=_numbered)


def _numbered(file: Path) -> list[tuple[str, int]]:
    """Return a sort key by name, with numbers in names by their value."""
    # `trial_10` follows `trial_9`, unlike in the order of letters.
    return [(word, int(number or 0)) for word, number in re.findall(r"(\D*)(\d*)", file.name)]


def read_learned(file: Path) -> Learned:
    """Read a learned policy, the models that it names, and its journal.

    Raises:
        DiagnosticsError: A document has errors, or the file is of another kind.
        UsageError: The policy was written by hand, or its journal is damaged.
    """
    library, notes = Library(), list[str]()
    policy = library.read(file, PolicyDocument).document
    if policy.curve is None or not policy.curve.reward:
        raise UsageError(f"{file}: a written policy, without episodes; try cb show policy {file}")
    require_legible(policy, file)
    experiences = _from_journal(file, len(policy.curve.reward))
    models = []
    # A policy without one of its densities is still worth a page; a note states the reason.
    for name, document in _models(file, policy):
        try:
            models.append(_model(library, file, name, document))
        except (UsageError, DiagnosticsError, UrdfError) as error:
            notes.append(f"Without the internal model {document}: {_reason(error)}.")
    digest = digest_of_bytes(file.read_bytes())
    programs = frozenset(_programs(library, file, policy))
    return Learned(
        file, digest, policy, programs, tuple(models), policy.curve, experiences, tuple(notes)
    )


def _reason(error: Exception) -> str:
    if isinstance(error, DiagnosticsError):
        return error.diagnostics[0].message
    return str(error)


def _programs(library: Library, file: Path, policy: PolicyDocument) -> Iterator[str]:
    """Yield names of programs that the policy's own program uses, as far as they can be found."""
    path = library.find(ProgramDocument, policy.program, file)
    try:
        if path is not None:
            yield from library.read(path, ProgramDocument).document.use
    except DiagnosticsError:
        return


def _models(file: Path, policy: PolicyDocument) -> Iterator[tuple[str | None, str]]:
    """Yield names in the program and of documents, of the policy and others learned with it."""
    yield from policy.models.items()
    for path in sorted(file.parent.glob(f"{file.stem}_*.yaml")):
        if path.stem not in policy.models.values() and is_of(ModelDocument, path):
            yield None, path.stem


def _model(library: Library, file: Path, name: str | None, document: str) -> InternalModel:
    path = library.find(ModelDocument, document, file)
    if path is None:
        raise UsageError(f"unknown model '{document}'")
    model = library.read(path, ModelDocument).document
    if model.space == "position":
        raise UsageError("it is over positions, which have no limits to draw it between")
    place = library.find(RobotDocument, model.robot, path)
    if place is None:
        raise UsageError(f"unknown robot '{model.robot}', which defines its joint limits")
    robot = library.read(place, RobotDocument).document
    known = {*robot.effectors, *robot.groups}
    if model.effector not in known:
        raise UsageError(f"robot '{model.robot}' has no effector '{model.effector}'")
    joints = read_urdf(place.parent / robot.model).joints
    limits = tuple(
        Joint(each, joints[each].lower, joints[each].upper, joints[each].unit)
        for each in robot.joints(model.effector)
        if each in joints
    )
    density = model.density
    angles = (
        (density.mean, density.deviation)
        if density.form == "gaussian"
        else (*density.samples, density.bandwidth)
    )
    if any(len(each) != len(limits) for each in angles):
        raise UsageError(f"it needs {count(len(limits), 'angle')}, as '{model.effector}' has")
    return InternalModel(name, model, limits)


def _from_journal(file: Path, number: int) -> tuple[Experience, ...]:
    """Return the first episodes of the journal beside a policy; empty without a journal.

    Args:
        file: File of the policy.
        number: Number of episodes.

    Raises:
        UsageError: The file is no journal, or holds fewer episodes.
    """
    path = file.with_suffix(_JOURNAL)
    if not path.exists():
        return ()
    try:
        lines = contents(path, MOST_BYTES).splitlines(keepends=True)
    except OSError as error:
        raise UsageError(f"{path}: {reason(error)}") from error
    # The first line is the header of the journal. Episodes beyond those of the policy are left out.
    rows, _ = rows_of(b"".join(lines[: 1 + number]), path)
    experiences = tuple(EPISODES.parse(row, path, line) for line, row in enumerate(rows[1:], 2))
    if len(experiences) < number:
        raise UsageError(f"{path}: holds {len(experiences)} episodes, and {file.name} {number}")
    return experiences
