"""The stage document: a training context, set up by the experimenter and unseen by the robot."""

import hashlib
import math
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    Field,
    FieldSerializationInfo,
    PrivateAttr,
    ValidationInfo,
    field_serializer,
    model_validator,
)

from cbdsl.documents.document import (
    Angle,
    AngleSpan,
    Color,
    Count,
    Document,
    Length,
    LengthSpan,
    MassSpan,
    Name,
    NonNegative,
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
from cbdsl.documents.kind import Kind

Side = Literal["-x", "+x", "-y", "+y"]
"""Where a side looks while the thing's yaw is 0."""


#: Most solids that something composed, or a mesh, is made of.
MOST_PIECES = 16


class Spot(Section):
    """A round spot of another colour on the middle of a side.

    It is all of the surface on that side that is within ``radius`` of the axis through its middle.
    """

    face: Side = "-x"
    """Side that it is on: where it looks while the thing's yaw is 0."""
    radius: Size
    """Radius, across the axis."""
    color: Color
    """Red, green and blue, each from 0 to 1."""


def _require_own_sides(spots: tuple[Spot, ...]) -> None:
    """Raise ``ValueError`` where a side has two spots."""
    faces = [spot.face for spot in spots]
    if len(set(faces)) < len(faces):
        raise ValueError("two spots are on the same side")


class BallForm(Section):
    """A sphere."""

    shape: Literal["ball"]
    """Which shape it is."""
    radius: SizeSpan
    """Radius, or the span that it is drawn from."""
    spot: Spot | None = None
    """Pattern that is painted on a side of it."""
    spots: tuple[Spot, ...] = ()
    """Several of them, each on a side of its own."""

    @property
    def all_spots(self) -> tuple[Spot, ...]:
        """The spots, one or several."""
        return (*([self.spot] if self.spot else []), *self.spots)

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        _require_own_sides(self.all_spots)
        if any(spot.radius >= self.radius[0] for spot in self.all_spots):
            raise ValueError("the spot is larger than the side of the ball")
        return self


class Pattern(Section):
    """Black bars printed on the middle of a box's side, upright and next to each other."""

    face: Side = "-x"
    """Side that is printed on: where it looks while the box's yaw is 0."""
    height: Size
    """Length of the bars."""
    stripes: Annotated[tuple[Size, ...], Field(min_length=1)]
    """Widths of bar, gap, ..., bar from left to right for whoever looks at the side."""

    @model_validator(mode="after")
    def _ends_with_a_bar(self) -> Self:
        if len(self.stripes) % 2 == 0:
            raise ValueError("stripes begin and end with a bar, so that their number is odd")
        return self


class BoxForm(Section):
    """A cuboid; its edges lie along x, y and z while its yaw is 0."""

    shape: Literal["box"]
    """Which shape it is."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Edge lengths."""
    pattern: Pattern | None = None
    """Pattern that is printed on a side of it."""
    spot: Spot | None = None
    """Pattern that is painted on a side of it."""
    spots: tuple[Spot, ...] = ()
    """Several of them, each on a side of its own."""

    @property
    def all_spots(self) -> tuple[Spot, ...]:
        """The spots, one or several."""
        return (*([self.spot] if self.spot else []), *self.spots)

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        _require_own_sides(self.all_spots)
        (depth, _), (width, _), (height, _) = self.size
        for spot in self.all_spots:
            across = width if spot.face.endswith("x") else depth
            if 2 * spot.radius > min(across, height):
                raise ValueError("the spot is larger than the side of the box")
        return self

    @model_validator(mode="after")
    def _has_room_for_the_pattern(self) -> Self:
        if self.pattern is not None:
            (depth, _), (width, _), (height, _) = self.size
            across = width if self.pattern.face.endswith("x") else depth
            # Widths that add up to the edge's length may exceed it by a rounding error.
            if sum(self.pattern.stripes) > across + 1e-9 or self.pattern.height > height:
                raise ValueError("the pattern is larger than the side of the box")
        return self


class CylinderForm(Section):
    """A cylinder that stands upright."""

    shape: Literal["cylinder"]
    """Which shape it is."""
    radius: SizeSpan
    """Radius, or the span that it is drawn from."""
    height: SizeSpan
    """Height, or the span that it is drawn from."""


class TubeForm(Section):
    """A cylinder with a bore along its axis, which stands upright; its wall is made of 12 boxes."""

    shape: Literal["tube"]
    """Which shape it is."""
    radius: SizeSpan
    """Outer radius, or the span that it is drawn from."""
    height: SizeSpan
    """Height, or the span that it is drawn from."""
    wall: Size
    """Thickness of its wall."""

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if self.wall >= self.radius[0]:
            raise ValueError("the wall leaves no bore")
        return self


class OpenBoxForm(Section):
    """A box without a lid, made of 5 boxes."""

    shape: Literal["open_box"]
    """Which shape it is."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Outer edge lengths."""
    wall: Size
    """Thickness of its walls and its bottom."""

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        (depth, _), (width, _), (height, _) = self.size
        if 2 * self.wall >= min(depth, width) or self.wall >= height:
            raise ValueError("the walls leave no inside")
        return self


class Piece(Section):
    """A solid that something composed is made of."""

    form: Annotated[BallForm | BoxForm | CylinderForm, Field(discriminator="shape")]
    """Its shape and size."""
    position: Point = (0.0, 0.0, 0.0)
    """Centre, in a frame that all pieces share."""
    yaw: Angle = 0.0
    """How it is turned about z."""

    @model_validator(mode="after")
    def _is_definite(self) -> Self:
        form = self.form
        spans = form.size if isinstance(form, BoxForm) else (form.radius,)
        if isinstance(form, CylinderForm):
            spans = (*spans, form.height)
        if any(first != last for first, last in spans):
            raise ValueError("a piece has one size, which is not drawn")
        if isinstance(form, (BallForm, BoxForm)) and form.all_spots:
            raise ValueError("a piece has no spot")
        if isinstance(form, BoxForm) and form.pattern is not None:
            raise ValueError("a piece has no pattern")
        return self

    @property
    def halves(self) -> tuple[float, float, float]:
        """Half its extents along its own axes, m."""
        form = self.form
        if isinstance(form, BallForm):
            return (form.radius[0],) * 3
        if isinstance(form, CylinderForm):
            return form.radius[0], form.radius[0], form.height[0] / 2
        (x, _), (y, _), (z, _) = form.size
        return x / 2, y / 2, z / 2

    @property
    def reach(self) -> tuple[float, float, float]:
        """Half its extents along the axes of the shared frame, m."""
        x, y, z = self.halves
        if not isinstance(self.form, BoxForm):
            return x, y, z
        c, s = abs(math.cos(self.yaw)), abs(math.sin(self.yaw))
        return c * x + s * y, s * x + c * y, z


class ComposedForm(Section):
    """Up to 16 solids that are one thing; its centre is the middle of the box around them."""

    shape: Literal["composed"]
    """Which shape it is."""
    pieces: Annotated[tuple[Piece, ...], Field(min_length=1, max_length=MOST_PIECES)]
    """What it is made of. `cb show mesh FILE` writes those that fill a mesh."""

    @property
    def box(self) -> tuple[tuple[float, float], ...]:
        """First and last value along each axis of the box around all pieces, m."""
        return tuple(
            (
                min(piece.position[axis] - piece.reach[axis] for piece in self.pieces),
                max(piece.position[axis] + piece.reach[axis] for piece in self.pieces),
            )
            for axis in range(3)
        )

    @property
    def size(self) -> tuple[tuple[float, float], ...]:
        """Edges of the box around all pieces as spans of one value each, m."""
        edges = [last - first for first, last in self.box]
        return tuple((edge, edge) for edge in edges)


class MeshForm(Section):
    """A closed mesh; its centre is the middle of the box around it."""

    shape: Literal["mesh"]
    """Which shape it is."""
    file: Annotated[str, Field(min_length=1)]
    """Its file, STL or OBJ, with the path from the stage's folder."""
    scale: Size = 1.0
    """Length of the file's unit: 1 mm where its numbers are millimetres."""
    solid: Literal["hull", "boxes", "ball", "box", "cylinder"] = "hull"
    """What is touched: its convex hull; up to 16 boxes that fill it, for what is hollow; or the
    ball, box or upright cylinder around it."""

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _is_in_a_folder(self, info: ValidationInfo) -> Self:
        if info.context is not None:
            self._folder = info.context["folder"]
        return self

    @property
    def path(self) -> Path:
        """Its file."""
        return self._folder / self.file

    @field_serializer("file")
    def _by_its_content(self, file: str, info: FieldSerializationInfo) -> str:
        # What was learned with a mesh holds for this mesh, wherever it lies.
        if info.context is None or not self.path.is_file():
            return file
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    # A document is what it says, wherever it lies.
    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeshForm) and self.model_dump() == other.model_dump()

    def __hash__(self) -> int:
        return hash((self.file, self.scale, self.solid))


Form = BallForm | BoxForm | CylinderForm | TubeForm | OpenBoxForm | ComposedForm | MeshForm


class Surface(Section):
    """Material of a thing."""

    color: Color = (1.0, 0.0, 0.0)
    """Red, green and blue, each from 0 to 1."""
    friction: NonNegative = 0.8
    """Coefficient of lateral friction."""
    rolling_friction: NonNegative = 0.002
    """Coefficient of rolling friction: the lever of the normal force, m."""
    spinning_friction: NonNegative | None = None
    """Coefficient of friction against turning about the contact's normal, m; as much as that of
    rolling where it is not given."""

    @property
    def spinning(self) -> float:
        """Coefficient of spinning friction, given or not."""
        given = self.spinning_friction
        return self.rolling_friction if given is None else given


class Fixture(Surface):
    """A thing that does not move."""

    # Not the red of things, which robots look for.
    color: Color = (0.6, 0.45, 0.3)
    """Red, green and blue, each from 0 to 1."""
    form: Annotated[Form, Field(discriminator="shape")]
    """Its shape and size."""
    position: tuple[LengthSpan, LengthSpan, LengthSpan]
    """Centre, in the world frame; a span of a coordinate is drawn from."""

    @property
    def is_drawn(self) -> bool:
        """Whether chance decides where it is."""
        return any(first != last for first, last in self.position)

    @field_serializer("position")
    def _as_it_is_written(self, position: tuple[LengthSpan, ...]) -> list[float | list[float]]:
        return [first if first == last else [first, last] for first, last in position]


class ThingSection(Surface):
    """A thing that can be touched and moved."""

    form: Annotated[Form, Field(discriminator="shape")]
    """Its shape and size."""
    mass: MassSpan
    """Mass, or the span that it is drawn from."""


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
    """What it is beside, instead of x and y; without ``on`` and ``z`` it stands as low as that."""
    gap: LengthSpan | None = None
    """Distance between its surface and the tip of ``hand`` along +z, instead of ``z``."""
    hand: Name | None = None
    """Effector in whose reach it is put; x, y, z, yaw and pitch are then in the tip's frame."""
    pitch: AngleSpan = (0.0, 0.0)
    """Turn about its own y axis, after yaw; a positive one makes its -x side look upwards."""
    yaw: AngleSpan = (0.0, 0.0)
    """How it is turned about z."""
    held: bool = False
    """Held still by the experimenter, whatever presses against it, until it is released."""

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
    """How the experimenter carries a thing along until it is touched, or throws it."""

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


class Scatter(Section):
    """How far the experimenter moves a thing about in each turn."""

    deviation: Size
    """Standard deviation along x and along y from where it was put at first."""
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
    """Least distance between its surface and those of all other placed things, but for what it
    stands on and what stands on it."""


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


class Disturbance(Section):
    """Imperfections of the sensors in this context."""

    image_noise: NonNegative = 0.0
    """Standard deviation of pixel values, of 255."""
    camera_position: Length = 0.0
    """Distance of each camera from where the robot believes it to be."""
    camera_rotation: Angle = 0.0
    """Angle of each camera from how the robot believes it to be turned."""
    body: Count | None = None
    """Number of the body, whose cameras keep their errors; drawn in each episode without it."""


class WorldSection(Section):
    """The world from one episode to the next."""

    persistent: bool = False
    """Whether episodes go on in the world as the one before left it, robot and all."""
    put_back: Literal["nothing", "fallen", "moved"] = "fallen"
    """Things that the experimenter puts where they were at first before an episode goes on, unless
    the robot touches them or is in the way: those that fell 20 cm or more below that place, or
    moved 2 cm or more from it."""
    where: Literal["same", "anew"] = "same"
    """Whether they are put where they were, or at a place that is drawn anew."""


class StageDocument(Document):
    """Which things are shown to a robot, where, and how."""

    kind: Literal["stage"]
    """Says that this document is a stage."""
    robot: Name
    """Robot to which things are shown."""
    fixtures: dict[Name, Fixture] = {}
    """Things that do not move, by name."""
    things: dict[Name, ThingSection] = {}
    """Things that can be touched, by name."""
    contexts: Annotated[dict[Name, Context], Field(min_length=1)]
    """Ways in which an episode can begin, by name."""
    disturbance: Disturbance = Disturbance.model_construct()
    world: WorldSection = WorldSection.model_construct()

    @model_validator(mode="after")
    def _takes_turns_in_a_persistent_world(self) -> Self:
        shown = [each for c in self.contexts.values() for each in c.presentations.values()]
        if not self.world.persistent and any(each.takes_turns for each in shown):
            raise ValueError("things come and move from turn to turn of a `persistent` world only")
        return self


STAGE = Kind(
    StageDocument,
    folder="programs/stages",
    checker="cbdsl.checking.stage.stage:examine_stage",
    unknown="CB602",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "contexts": {"unknown": {}}},
)
