"""Objects of a stage by the channels of a program: whether there is any that it acts on."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.checking.rules.guards import check_fixtures
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import Channels, RobotDocument
from cbdsl.documents.stage import Fixture, StageDocument, ThingSection
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Relative
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.channel_spans import channels_of_color
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import channel_of
from cbdsl.yaml_text.loaded import Loaded


def check_on_stage(
    loaded: Loaded[ProgramDocument],
    program: CheckedProgram,
    session: Session,
    diagnostics: Diagnostics,
) -> None:
    """Report the fixtures and note the channels of a sound program that its stage lacks."""
    if program.stage is None:
        return
    place, library = loaded.source.place("stage"), session.library
    stage = library.find(StageDocument, program.stage, loaded.path)
    robot = library.find(RobotDocument, program.robot, loaded.path)
    if stage is None or robot is None:
        return
    shown = session.read(stage, StageDocument, diagnostics)
    body = session.read(robot, RobotDocument, diagnostics)
    if isinstance(shown, Unknown) or isinstance(body, Unknown):
        return
    check_fixtures(loaded.source, program, shown.document, body.document, diagnostics)
    for channel in absent_channels(program, shown.document, body.document.vision.channels):
        diagnostics.add("CB729", place, stage=program.stage, channel=channel)


def absent_channels(
    program: CheckedProgram, stage: StageDocument, channels: Channels
) -> tuple[str, ...]:
    """Return the channels of hue or saturation that a program looks for and no object has.

    A stage without objects is for programs that look in vain, or for real robots.
    """
    if not stage.things:
        return ()
    surfaces: list[Fixture | ThingSection] = [*stage.things.values(), *stage.fixtures.values()]
    spots = (spot for each in surfaces for spot in getattr(each.form, "all_spots", ()))
    colors = {each.color for each in (*surfaces, *spots)}
    there = {channel for color in colors for channel in channels_of_color(color, channels)}
    # Shade changes the intensity of a surface, and motion is of no surface.
    names = {name for name in channel_names(channels) if not name.startswith(("int_", "motion"))}
    wanted = dict.fromkeys(_channels(program))
    return tuple(name for name in wanted if name in names and name not in there)


def _channels(program: CheckedProgram) -> Iterator[str]:
    """Yield the channels of objects that controllers of a program and its subprograms act on."""
    for action in program.actions:
        for controller in action.controllers:
            reference = controller.reference
            base = reference.base if isinstance(reference, Relative) else reference
            yield channel_of(controller.feedback.source)
            yield channel_of(base.source) if isinstance(base, Resource) else ""
        if action.program is not None:
            yield from _channels(action.program)
