"""Contexts: which thing the experimenter presents, where, and how it moves."""

import math
from typing import Annotated, Self

from pydantic import (
    Field,
    model_validator,
)

from cbdsl.documents.document import (
    AngleSpan,
    Count,
    LengthSpan,
    Name,
    Point,
    Positive,
    PositiveCount,
    Section,
    Size,
    SizeSpan,
    SpeedSpan,
    Time,
    TimeSpan,
    quantity,
)


class BesideSection(Section):
    """A place at a level distance from a fixture or another placed thing."""

    name: Name
    """Fixture or placed thing that it is beside."""
    by: SizeSpan
    """Level distance between the centres."""
    direction: AngleSpan = (-math.pi, math.pi)
    """Direction from there in the world frame, 0 along x."""


class PlaceSection(Section):
    """Where a thing is put: on or beside something, at a height, or in reach of a hand."""

    x: LengthSpan = (0.0, 0.0)
    """Where it is along x, from the first to the last value. On a placed thing, or a fixture whose
    position is drawn, x, y, pitch and yaw are in the frame of that, else in the world frame."""
    y: LengthSpan = (0.0, 0.0)
    """Where it is along y."""
    z: LengthSpan | None = None
    """Height of the centre."""
    on: Name | None = None
    """Fixture or placed thing that it stands on, instead of ``z``."""
    beside: BesideSection | None = None
    """Neighbour that replaces x and y; without ``on`` and ``z`` it stands as low as its
    neighbour."""
    gap: LengthSpan | None = None
    """Distance between its surface and the tip of ``hand`` along +z, instead of ``z``."""
    hand: Name | None = None
    """Effector in whose reach it is put; x, y, z, yaw and pitch are then in the tip's frame."""
    pitch: AngleSpan = (0.0, 0.0)
    """Turn about its own y axis, after yaw; a positive one makes its -x side look upwards."""
    yaw: AngleSpan = (0.0, 0.0)
    """How it is turned about z."""
    held: bool = False
    """Held still by the experimenter against any force until its release."""

    @property
    def neighbours(self) -> tuple[str, ...]:
        """Names of the fixtures and placed things that it is on or beside."""
        beside = None if self.beside is None else self.beside.name
        return tuple(name for name in (self.on, beside) if name is not None)

    @model_validator(mode="after")
    def _says_where(self) -> Self:
        given = 3 - [self.z, self.on, self.gap].count(None)
        if given != 1 and not (given == 0 and self.beside is not None):
            raise ValueError("a place needs exactly one of z, on and gap, or `beside` alone")
        if self.hand is None and self.gap is not None:
            raise ValueError("gap needs a hand")
        if self.beside is not None and (self.hand or self.x != (0, 0) or self.y != (0, 0)):
            raise ValueError("a place `beside` something has no x, y and hand of its own")
        return self


class Motion(Section):
    """How the experimenter carries a thing along until it is touched, shakes it, or throws it."""

    speed: SpeedSpan
    """Horizontal speed."""
    direction: AngleSpan
    """Direction in the world frame, 0 along x."""
    upward: SpeedSpan = (0.0, 0.0)
    """Vertical speed of a throw."""
    thrown: bool = False
    """Given its speed once, instead of carried at it."""
    after: TimeSpan = (0.0, 0.0)
    """When the motion starts."""
    within: Size | None = None
    """Shaken so far to either side of its place, at that speed in the middle, instead of carried
    straight on; a throw has none."""

    @model_validator(mode="after")
    def _is_shaken_or_thrown(self) -> Self:
        if self.thrown and self.within is not None:
            raise ValueError("what is thrown flies on: `within` is for what is shaken")
        return self


class Scatter(Section):
    """How far the experimenter moves a thing about in each turn."""

    deviation: Size
    """Standard deviation along x and along y from its first place."""
    x: LengthSpan
    """Bounds of its place along x, in the world frame."""
    y: LengthSpan
    """Bounds of its place along y, in the world frame."""


class Displacement(Section):
    """A move of a thing in one turn of the experimenter, after which it belongs there."""

    turn: PositiveCount
    """Which turn."""
    by: Point
    """How far, in the world frame."""


class Presentation(Section):
    """A thing that is shown, its place, and the experimenter's actions on it."""

    things: tuple[Name, ...] = ()
    """One of these is presented, drawn evenly; none: nothing is."""
    place: PlaceSection | None = None
    motion: Motion | None = None
    released_after: Time | None = None
    """When the experimenter lets go of a held thing; never without it."""
    removed_after: Time | None = None
    """When the thing is taken away."""
    returned_after: Time | None = None
    """How long after it fell from where it was put the experimenter puts it there again."""
    from_turn: Count = 0
    """Turn of the experimenter in which it is put there; 0 is the first episode's beginning."""
    scattered: Scatter | None = None
    """How it is moved in each turn."""
    displaced: tuple[Displacement, ...] = ()
    """Moves that last."""

    @property
    def takes_turns(self) -> bool:
        """Whether it comes or moves between episodes."""
        return bool(self.from_turn or self.scattered or self.displaced)


class PlacedSection(Presentation):
    """One of several things that are in the world together, under a name of its own."""

    things: Annotated[tuple[Name, ...], Field(min_length=1)]
    """One of these is presented, drawn evenly."""
    place: PlaceSection
    apart: Annotated[float, quantity("length", ge=0)] = 0.0
    """Least distance between its surface and those of all other placed things, except for
    support contacts."""


class Context(Presentation):
    """One way in which an episode can begin."""

    share: Positive = 1.0
    """Relative frequency."""
    placed: dict[Name, PlacedSection] = {}
    """Several things, instead of one of ``things``: by the names that they have in the world."""
    joints: dict[str, AngleSpan] = {}
    """Where these joints start, instead of their effector's start posture."""
    dark_after: Time | None = None
    """When the light goes out, after which cameras see nothing."""

    @model_validator(mode="after")
    def _places_one_or_several(self) -> Self:
        if self.placed and (self.things or self.place is not None):
            raise ValueError("a context has either `things` with a `place`, or `placed` things")
        return self

    @property
    def presentations(self) -> dict[str | None, Presentation]:
        """All that it shows, by name; ``None`` for what has the name of the thing that is drawn."""
        return dict(self.placed.items()) if self.placed else {None: self}
