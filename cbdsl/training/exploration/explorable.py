"""Explorable actions: programs bound to a feature, and the signals of their models."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace

from cbdsl.documents.document_digest import ProgramDigest
from cbdsl.documents.robot import RobotDocument
from cbdsl.learning.catalogs.action_outcome import FeatureForm
from cbdsl.program.checked import CheckedProgram
from cbdsl.robot.channel_names import color_of, hue_names
from cbdsl.types.resource import CYCLOPEAN, Origin, Resource
from cbdsl.types.source_record import camera_of, hues_of, is_located

#: Placeholder of a channel that is found while the action runs.
OPEN = "?"


@dataclass(frozen=True)
class Explorable:
    """Action that can be explored.

    Attributes:
        name: Name in the catalog.
        program: Program of the action.
        digest: Digest of the program's text.
        features: Signals of its model, by name.
        presence: Heading that is defined while the action's object is seen.
        marks: Possible actions by the channel that is found while this action runs.
    """

    name: str
    program: CheckedProgram
    digest: ProgramDigest
    features: Mapping[str, Resource]
    presence: Resource
    marks: Mapping[str, Explorable] = field(default_factory=dict)

    @property
    def forms(self) -> tuple[FeatureForm, ...]:
        """Forms of the features for a model."""
        return tuple(
            FeatureForm(name, resource.type.unit, resource.type.size)
            for name, resource in self.features.items()
        )

    @property
    def observed(self) -> tuple[Resource, ...]:
        """All signals that are read besides the signals of its program."""
        own = [each for each in self.features.values() if each.origin is not Origin.SURFACE]
        marked = [each for mark in self.marks.values() for each in mark.observed]
        return (*own, self.presence, *marked)


def features_of(
    program: CheckedProgram, resources: Mapping[str, Resource]
) -> tuple[dict[str, Resource], Resource] | None:
    """Return the features of a program's rewarded signal, and the heading to its object.

    For a tracked object they are heading, its velocity and the region's extent in the first camera.
    For a touched object they are position, velocity and volume, for a surface the drawn point
    (Section 6.2.2).

    Args:
        program: Checked program.
        resources: Resources of its robot, by name.

    Returns:
        Features and heading; ``None`` if the program is rewarded for neither tracking nor touching.
    """
    rewarded = [each.lead for each in program.primitives.values() if each.rewarded]
    tracked = next(filter(None, [_tracked(each.feedback) for each in rewarded]), None)
    if tracked is not None:
        head = _heading(tracked, resources)
        names = {"heading": "", "velocity": ".velocity", "extent": ".extent"}
        return _known(head.name, names, resources), head
    place = next(_places(program), None)
    if place is None or not rewarded:
        return None
    # The channel of stereo.red is red, and so is that of surface.red.
    head = _heading(place.name.partition(".")[2], resources)
    if place.origin is Origin.SURFACE:
        return {"place": place}, head
    names = {"place": "", "velocity": ".velocity", "volume": ".volume"}
    return _known(place.name, names, resources), head


def explorable(
    name: str, program: CheckedProgram, digest: ProgramDigest, resources: Mapping[str, Resource]
) -> Explorable | None:
    """Return an action; ``None`` if its program is rewarded for neither tracking nor touching.

    Args:
        name: Name in the catalog.
        program: Program of the action.
        digest: Digest of the program's text.
        resources: Resources of its robot, by name.
    """
    read = features_of(program, resources)
    return None if read is None else Explorable(name, program, digest, *read)


def with_marks(
    name: str,
    values: Mapping[str, str],
    bind: Callable[[str, Mapping[str, str]], Explorable],
    robot: RobotDocument,
) -> Explorable:
    """Return an action; an open value (``?``) gives it one mark for each possible channel.

    Args:
        name: Name in the catalog.
        values: Values of its program's parameters, at most one of them open.
        bind: Function that returns an action for a name and its values.
        robot: Robot that defines the channels; the action's own channel is left out.
    """
    closed = {key: value for key, value in values.items() if value != OPEN}
    action = bind(name, closed)
    own = {action.program.parameters.get("feature", "")}
    marks = {
        channel: bind(f"{name}_{channel}", {**closed, key: channel})
        # At most one parameter is open, so that each channel gives one mark.
        for key in values.keys() - closed.keys()
        for channel in other_hues(robot, own)
    }
    return replace(action, marks=marks)


def other_hues(robot: RobotDocument, own: Collection[str]) -> list[str]:
    """Return the named colours and the other channels of hue except some.

    A hue goes by its alias if it has one, and is left out if a named colour contains it.
    """
    channels = robot.vision.channels
    aliases = {channel: alias for alias, channel in channels.aliases.items()}
    taken = {color_of(name, channels) for name in own}
    hues = dict.fromkeys(color_of(name, channels) for name in hue_names(channels))
    return [aliases.get(hue, hue) for hue in hues if hue not in taken]


def _tracked(feedback: Resource) -> str | None:
    """Return the channel of a heading or of a mark of one hue; ``None`` for other signals."""
    if camera_of(feedback):
        return feedback.name.partition(".")[2]
    if len(hues_of(feedback.source)) == 1:
        # A mark of one hue counts as its own object: mark.red.blue is of the channel blue.
        return feedback.name.rpartition(".")[2]
    return None


def _known(
    base: str, endings: Mapping[str, str], resources: Mapping[str, Resource]
) -> dict[str, Resource]:
    return {
        name: resources[base + ending]
        for name, ending in endings.items()
        if base + ending in resources
    }


def _heading(channel: str, resources: Mapping[str, Resource]) -> Resource:
    """Return the heading of a channel in the first camera."""
    return next(
        each
        for name, each in resources.items()
        if name.partition(".")[2] == channel and camera_of(each) not in ("", CYCLOPEAN)
    )


def _places(program: CheckedProgram) -> Iterator[Resource]:
    """Yield the places that controllers of a program go to, its own first."""
    for action in program.actions:
        for controller in action.controllers:
            reference = controller.reference
            if isinstance(reference, Resource) and _is_place(reference):
                yield reference
    for action in program.actions:
        if action.program is not None:
            yield from _places(action.program)


def _is_place(resource: Resource) -> bool:
    return is_located(resource.source) or resource.origin is Origin.SURFACE
