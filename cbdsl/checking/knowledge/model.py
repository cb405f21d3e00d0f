"""Model documents against their robots, and what programs can name of them."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.checking.lookup.documents import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.documents.model import Gaussian, ModelDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.errors.counting import count
from cbdsl.program.binding import density_source
from cbdsl.types.resource import Origin, Resource
from cbdsl.types.resource_type import POSITION, configuration
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step


def examine_model(loaded: Loaded[ModelDocument], session: Session, findings: Findings) -> None:
    """Check a model against its robot."""
    if loaded.faults:
        return  # a density makes sense as a whole
    name, place = loaded.document.robot, loaded.source.place("robot")
    path = find_document(RobotDocument, name, place, session.library, findings)
    body = session.body(path, findings)
    if body is not None and loaded.document.effector not in body.missed:
        _fits(loaded, body, findings)


def model_resource(
    alias: str, loaded: Loaded[ModelDocument], body: CheckedRobot, findings: Findings
) -> Resource | None:
    """Resource ``<effector>.<alias>`` of a program, or ``None`` where the model does not fit."""
    if not _fits(loaded, body, findings):
        return None
    document, effector = loaded.document, loaded.document.effector
    is_place = document.space == "position"
    kind = POSITION if is_place else configuration(len(body.document.joints(effector)))
    source = density_source(effector, document.density)
    return Resource(f"{effector}.{alias}", kind, Origin.MODEL, source)


def _fits(loaded: Loaded[ModelDocument], body: CheckedRobot, findings: Findings) -> bool:
    """Whether a model's effector is there, and has what the model has numbers for."""
    document, source, robot = loaded.document, loaded.source, body.document
    names = [*robot.effectors, *robot.groups]
    if document.effector not in names:
        place = source.place("effector")
        findings.add("CB308", place, names=names, name=document.effector, what="effector")
        return False
    is_place = document.space == "position"
    if is_place and not _has_a_tip(document.effector, robot):
        tipped = [name for name in names if _has_a_tip(name, robot)]
        place = source.place("effector")
        findings.add("CB670", place, names=tipped, name=document.effector)
        return False
    if is_place and document.density.uniform:
        findings.add("CB671", source.place("density", "uniform"), share=document.density.uniform)
        return False
    wanted = 3 if is_place else len(robot.joints(document.effector))
    number = "coordinate" if is_place else "angle"
    wrong = [(steps, length) for steps, length in _lengths(document) if length != wanted]
    for steps, length in wrong:
        has = "3 axes" if is_place else count(wanted, "joint")
        details = {"found": count(length, number), "wanted": has}
        findings.add("CB631", source.place(*steps), name=document.effector, **details)
    return not wrong


def _has_a_tip(name: str, robot: RobotDocument) -> bool:
    """Whether a name is that of an effector with one tip, which has a position."""
    effector = robot.effectors.get(name)
    return effector is not None and effector.tip is not None


def _lengths(document: ModelDocument) -> list[tuple[tuple[Step, ...], int]]:
    """How many angles each part of a density has."""
    density = document.density
    if isinstance(density, Gaussian):
        return [
            (("density", "mean"), len(density.mean)),
            (("density", "deviation"), len(density.deviation)),
        ]
    return [
        (("density", "bandwidth"), len(density.bandwidth)),
        *((("density", "samples", i), len(sample)) for i, sample in enumerate(density.samples)),
    ]
