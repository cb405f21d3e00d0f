"""Checks of model documents against their robots, and the resources that they define."""

from __future__ import annotations

from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.model import Gaussian, ModelDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.binding import density_source
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.resources import NOVEL, configuration_of
from cbdsl.types.resource import NovelHeading, Origin, Resource
from cbdsl.types.resource_type import HEADING, POSITION
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step


def examine_model(
    loaded: Loaded[ModelDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check a model against its robot."""
    if loaded.diagnostics:
        return  # a density with missing parts cannot be checked
    name, place = loaded.document.robot, loaded.source.place("robot")
    path = find_document(RobotDocument, name, place, session.library, diagnostics)
    body = session.body(path, diagnostics)
    if not isinstance(body, Unknown) and loaded.document.effector not in body.missed:
        _fits(loaded, body, diagnostics)


def model_resources(
    alias: str, loaded: Loaded[ModelDocument], body: CheckedRobot, diagnostics: Diagnostics
) -> Outcome[tuple[Resource, ...]]:
    """Return the resources of a model for a program; unknown if the model does not fit.

    They are ``<effector>.<alias>`` and, for the background of a channel, ``novel.<channel>``, also
    under the other names of the channel.
    """
    if not _fits(loaded, body, diagnostics):
        return UNKNOWN
    document, effector = loaded.document, loaded.document.effector
    is_place = document.space == "position"
    kind = POSITION if is_place else configuration_of(body.document.joints(effector), body.model)
    source = density_source(effector, document.density)
    drawn = Resource(f"{effector}.{alias}", kind, Origin.MODEL, source)
    if document.channel is None:
        return (drawn,)
    aliases = body.document.vision.channels.aliases
    channel = aliases.get(document.channel, document.channel)
    names = [channel, *(name for name, own in aliases.items() if own == channel)]
    heading = NovelHeading(channel, effector, source)
    novel = [Resource(f"{NOVEL}.{name}", HEADING, Origin.ENVIRONMENT, heading) for name in names]
    return (drawn, *novel)


def _fits(loaded: Loaded[ModelDocument], body: CheckedRobot, diagnostics: Diagnostics) -> bool:
    """Return whether the robot has a model's effector, with as many coordinates as the model."""
    document, source, robot = loaded.document, loaded.source, body.document
    names = [*robot.effectors, *robot.groups]
    if document.effector not in names:
        place = source.place("effector")
        diagnostics.add("CB308", place, names=names, name=document.effector, what="effector")
        return False
    is_place = document.space == "position"
    if is_place and not _has_a_tip(document.effector, robot):
        tipped = [name for name in names if _has_a_tip(name, robot)]
        place = source.place("effector")
        diagnostics.add("CB670", place, names=tipped, name=document.effector)
        return False
    # Positions have no limits between which a uniform sample could be drawn.
    if is_place and document.density.uniform:
        diagnostics.add("CB671", source.place("density", "uniform"), share=document.density.uniform)
        return False
    if document.channel is not None and not _is_background(loaded, body, diagnostics):
        return False
    wanted = 3 if is_place else len(robot.joints(document.effector))
    number = "coordinate" if is_place else "angle"
    wrong = [(steps, length) for steps, length in _lengths(document) if length != wanted]
    for steps, length in wrong:
        has = "3 axes" if is_place else count(wanted, "joint")
        details = {"found": count(length, number), "wanted": has}
        diagnostics.add("CB631", source.place(*steps), name=document.effector, **details)
    return not wrong


def _is_background(
    loaded: Loaded[ModelDocument], body: CheckedRobot, diagnostics: Diagnostics
) -> bool:
    """Return whether the robot has a model's channel, and its effector moves a camera."""
    document, robot = loaded.document, body.document
    channels = robot.vision.channels
    # Resting cameras see motion, which has no expected direction.
    known = [name for name in (*channel_names(channels), *channels.aliases) if name != "motion"]
    if not robot.cameras or document.channel not in known:
        place = loaded.source.place("channel")
        names = known if robot.cameras else []
        diagnostics.add("CB672", place, names=names, name=document.channel, robot=robot.name)
        return False
    links = [camera.link for camera in robot.main_cameras.values()]
    if body.model is None or not body.model.links.issuperset(links):
        return True  # as far as the model is known
    moving = [
        name
        for name in (*robot.effectors, *robot.groups)
        if any(body.moves(name, link) for link in links)
    ]
    if document.space == "position" or document.effector not in moving:
        place = loaded.source.place("effector" if document.space != "position" else "space")
        diagnostics.add("CB673", place, names=moving, name=document.effector)
        return False
    return True


def _has_a_tip(name: str, robot: RobotDocument) -> bool:
    """Return whether a name is an effector's with one tip, which has a position."""
    effector = robot.effectors.get(name)
    return effector is not None and effector.tip is not None


def _lengths(document: ModelDocument) -> list[tuple[tuple[Step, ...], int]]:
    """Return the number of coordinates of each part of a density, with its path."""
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
