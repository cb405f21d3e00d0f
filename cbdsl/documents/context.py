"""Contexts: which thing the experimenter presents, where, and how it moves."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

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
    """Place at a horizontal distance from a fixture or another placed object."""

    name: Name
    """Fixture or placed object at that distance."""
    by: SizeSpan
    """Horizontal distance between the centres."""
    direction: AngleSpan = (-math.pi, math.pi)
    """Direction from its centre in the world frame, 0 along x."""


class PlaceSection(Section):
    """Place of an object: on or beside something, at a height, or within reach of a hand."""

    x: LengthSpan = (0.0, 0.0)
    """Position along x, from the first to the last value. x, y, pitch and yaw are in the world
    frame, or on a placed object or a fixture with a drawn position, in its frame."""
    y: LengthSpan = (0.0, 0.0)
    """Position along y."""
    z: LengthSpan | None = None
    """Height of the centre."""
    on: Name | None = None
    """Fixture or placed object that supports the object, instead of ``z``."""
    beside: BesideSection | None = None
    """Neighbour that replaces x and y; without ``on`` and ``z``, the object stands as low as its
    neighbour."""
    gap: LengthSpan | None = None
    """Distance between the surface of the object and the tip of ``hand`` along +z, instead of
    ``z``."""
    hand: Name | None = None
    """Effector that has the object within reach; x, y, z, yaw and pitch are then in the tip's
    frame."""
    pitch: AngleSpan = (0.0, 0.0)
    """Rotation about the object's own y axis, after yaw; a positive pitch turns its -x side
    upwards."""
    yaw: AngleSpan = (0.0, 0.0)
    """Rotation about z."""
    held: bool = False
    """True if the experimenter holds the object against any force until its release."""

    @property
    def neighbours(self) -> tuple[str, ...]:
        """Names of the fixture and the object that the place refers to."""
        beside = None if self.beside is None else self.beside.name
        return tuple(name for name in (self.on, beside) if name is not None)

    @model_validator(mode="after")
    def _says_where(self) -> Self:
        # Valid places have one height: ``z: 1 m``, ``on: table``, ``gap: 2 cm`` from the tip of a
        # hand, or the level of the neighbour for ``beside`` alone.
        given = 3 - [self.z, self.on, self.gap].count(None)
        if given != 1 and not (given == 0 and self.beside is not None):
            raise ValueError("a place needs exactly one of z, on and gap, or `beside` alone")
        if self.hand is None and self.gap is not None:
            raise ValueError("gap needs a hand")
        if self.beside is not None and (self.hand or self.x != (0, 0) or self.y != (0, 0)):
            raise ValueError("a place `beside` something has no x, y and hand of its own")
        return self


class Motion(Section):
    """Motion by the experimenter: the object is carried until it is touched, shaken, or thrown."""

    speed: SpeedSpan
    """Horizontal speed."""
    direction: AngleSpan
    """Direction in the world frame, 0 along x."""
    upward: SpeedSpan = (0.0, 0.0)
    """Vertical speed of a throw."""
    thrown: bool = False
    """True if the object gets its speed once, instead of being carried."""
    after: TimeSpan = (0.0, 0.0)
    """Start of the motion."""
    within: Size | None = None
    """Amplitude of a shaking motion about its place, with the given speed in the middle; without
    it, the object is carried straight on. Not for a throw."""

    @model_validator(mode="after")
    def _is_shaken_or_thrown(self) -> Self:
        if self.thrown and self.within is not None:
            raise ValueError("`within` applies to shaken objects, not to thrown ones")
        return self


class Scatter(Section):
    """Random displacement of an object by the experimenter in each turn."""

    deviation: Size
    """Standard deviation along x and along y from its first place."""
    x: LengthSpan
    """Bounds of its position along x, in the world frame."""
    y: LengthSpan
    """Bounds of its position along y, in the world frame."""


class Displacement(Section):
    """Permanent displacement of an object in one turn of the experimenter."""

    turn: PositiveCount
    """Number of the turn."""
    by: Point
    """Displacement, in the world frame."""


class Presentation(Section):
    """Object that is shown, its place, and the experimenter's actions on it."""

    things: tuple[Name, ...] = ()
    """Objects to draw one from, with equal probability; without any, no object is shown."""
    place: PlaceSection | None = None
    motion: Motion | None = None
    released_after: Time | None = None
    """Time after which the experimenter releases a held object; never without it."""
    removed_after: Time | None = None
    """Time after which the object is removed."""
    returned_after: Time | None = None
    """Time between the fall of the object from its place and its return by the experimenter."""
    from_turn: Count = 0
    """Turn of the experimenter in which the object appears; 0 is the start of the first episode."""
    scattered: Scatter | None = None
    """Random displacement in each turn."""
    displaced: tuple[Displacement, ...] = ()
    """Permanent displacements."""

    @property
    def takes_turns(self) -> bool:
        """True if the object appears or moves between episodes."""
        return bool(self.from_turn or self.scattered or self.displaced)


class PlacedSection(Presentation):
    """One of several objects that are present simultaneously, with a name of its own."""

    things: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Objects to draw one from, with equal probability."""
    place: PlaceSection
    apart: Annotated[float, quantity("length", ge=0)] = 0.0
    """Minimum distance between its surface and those of all other placed objects, except for
    support contacts."""


class Context(Presentation):
    """One way to begin an episode."""

    share: Positive = 1.0
    """Relative frequency."""
    relation: Name | None = None
    """Relation of the objects when brought together, as the experimenter names it to a learner."""
    placed: dict[Name, PlacedSection] = {}
    """Several objects instead of one of ``things``, by their names in the world."""
    joints: dict[str, AngleSpan] = {}
    """Start positions of joints that replace their effector's start posture."""
    dark_after: Time | None = None
    """Time after which the light goes out and cameras see nothing."""

    @model_validator(mode="after")
    def _places_one_or_several(self) -> Self:
        if self.placed and (self.things or self.place is not None):
            raise ValueError("a context has either `things` with a `place`, or `placed` things")
        return self

    @property
    def presentations(self) -> dict[str | None, Presentation]:
        """Presentations by name; the key of a single drawn object is ``None``."""
        return dict(self.placed.items()) if self.placed else {None: self}
