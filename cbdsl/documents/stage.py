"""The stage document: a training context, set up by the experimenter and unseen by the robot."""

from typing import Annotated, Literal, Self

from pydantic import (
    Field,
    field_serializer,
    model_validator,
)

from cbdsl.documents.context import Context
from cbdsl.documents.document import (
    Angle,
    Color,
    Count,
    Document,
    Length,
    LengthSpan,
    MassSpan,
    Name,
    NonNegative,
    Section,
)
from cbdsl.documents.form import Form
from cbdsl.documents.kind import Kind


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
    """Things that the experimenter returns to their first places between episodes, unless the
    robot touches them or is in the way: things that fell 20 cm or more below that place, or
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
