"""Objects of a program that were seen once and have no remembered position."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller, Relative
from cbdsl.sensing.vision.vision import Vision
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import channels_of


class Loss(NamedTuple):
    """Object that was seen once and has no remembered position.

    Attributes:
        channel: Name of the object's channel.
        seconds: Time since the object was last seen, s.
        place: Last seen position, m, world frame.
    """

    channel: str
    seconds: float
    place: tuple[float, ...]

    def __str__(self) -> str:
        place = ", ".join(f"{100 * x:.0f}" for x in self.place)
        return (
            f"the object of {self.channel} is gone: last seen {self.seconds:.1f} s before, "
            f"at ({place}) cm"
        )


class LostObjects:
    """Finder of the lost objects of a program's channels; obstacles do not count.

    Args:
        program: Program whose controllers act on objects.
        vision: Vision of the robot.
        aliases: Channels by their names in programs.
    """

    def __init__(self, program: CheckedProgram, vision: Vision, aliases: Mapping[str, str]) -> None:
        self._vision = vision
        self._names = {channel: alias for alias, channel in aliases.items()}
        known = vision.instances
        self._channels = [name for name in dict.fromkeys(_channels(program)) if name in known]

    def find(self, time: float) -> Iterator[Loss]:
        """Yield the objects that are lost at a time, s."""
        for channel in self._channels:
            instances = self._vision.instances[channel]
            if instances.known:
                continue
            seen = [memory.last for memory in instances.memories if memory.last is not None]
            # Of several objects of one channel, the one seen last stands for all.
            for last, place in sorted(seen, key=lambda each: -each[0])[:1]:
                name = self._names.get(channel, channel)
                yield Loss(name, time - last, tuple(place.tolist()))


def _channels(program: CheckedProgram) -> Iterator[str]:
    """Yield the channels of the objects that a program and its subprograms act on."""
    compositions = [action.composition for action in program.actions]
    for composition in (*compositions, program.background):
        for controller in composition.controllers if composition else ():
            for resource in _compared(controller):
                yield from itertools.islice(channels_of(resource.source), 1)
    for action in program.actions:
        if action.program is not None:
            yield from _channels(action.program)


def _compared(controller: Controller) -> Iterator[Resource]:
    """Yield a controller's feedback and its reference, or the base of a relative reference."""
    yield controller.feedback
    reference = controller.reference
    base = reference.base if isinstance(reference, Relative) else reference
    if isinstance(base, Resource):
        yield base
