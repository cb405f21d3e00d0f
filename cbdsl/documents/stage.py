"""The stage document: a training context, set up by the experimenter and unseen by the robot."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_serializer, model_validator

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
    written,
)
from cbdsl.documents.form import Form
from cbdsl.documents.kind import Kind
from cbdsl.types.relative import ANY_ROBOT


class Surface(Section):
    """Material of an object."""

    color: Color = (1.0, 0.0, 0.0)
    """Red, green and blue, each from 0 to 1."""
    friction: NonNegative = 0.8
    """Coefficient of lateral friction."""
    rolling_friction: NonNegative = 0.002
    """Coefficient of rolling friction: lever of the normal force, m."""
    spinning_friction: NonNegative | None = None
    """Coefficient of friction against turning about the contact's normal, m; the coefficient of
    rolling if omitted."""

    @property
    def spinning(self) -> float:
        """Coefficient of spinning friction, given or by default."""
        given = self.spinning_friction
        return self.rolling_friction if given is None else given


class Fixture(Surface):
    """Object that does not move."""

    # Not the red of things, which robots look for.
    color: Color = (0.6, 0.45, 0.3)
    """Red, green and blue, each from 0 to 1."""
    form: Annotated[Form, Field(discriminator="shape")]
    """Shape and size."""
    position: tuple[LengthSpan, LengthSpan, LengthSpan]
    """Centre, in the world frame; a coordinate may be a range to draw it from."""

    @property
    def is_drawn(self) -> bool:
        """True if the position is random."""
        return any(first != last for first, last in self.position)

    @field_serializer("position")
    def _as_it_is_written(self, position: tuple[LengthSpan, ...]) -> list[Any]:
        ends = [[written(each) for each in span] for span in position]
        return [first if first == last else [first, last] for first, last in ends]


class ThingSection(Surface):
    """Object that can be touched and moved."""

    form: Annotated[Form, Field(discriminator="shape")]
    """Shape and size."""
    mass: MassSpan
    """Mass, or the range to draw it from."""


class Disturbance(Section):
    """Imperfections of the sensors in this context."""

    image_noise: NonNegative = 0.0
    """Standard deviation of pixel values, of 255."""
    camera_position: Length = 0.0
    """Distance of each camera from its assumed place."""
    camera_rotation: Angle = 0.0
    """Angle of each camera from its assumed orientation."""
    body: Count | None = None
    """Number of the body, which determines the errors of its cameras; drawn in each episode if
    omitted."""


class WorldSection(Section):
    """World between episodes."""

    persistent: bool = False
    """True if each episode starts from the state of robot and world at the end of the last one."""
    put_back: Literal["nothing", "fallen", "moved"] = "fallen"
    """Objects that the experimenter returns to their first places between episodes: objects that
    fell by 20 cm or more, or moved by 2 cm or more. They stay if the robot touches them or is in
    the way."""
    where: Literal["same", "anew"] = "same"
    """Place of the return: the first one, or a newly drawn one."""


class StageDocument(Document):
    """Objects that are shown to a robot, with their places and motions."""

    kind: Literal["stage"]
    """Kind of this document: a stage."""
    robot: Name
    """Robot of the stage. A stage for `any` robot may state lengths as sums of measures of the
    robot: `0.4 reach`, `1.2 span`, and the top of a bench before it, `bench.x`."""
    fixtures: dict[Name, Fixture] = {}
    """Objects that do not move, by name."""
    things: dict[Name, ThingSection] = {}
    """Objects that can be touched, by name."""
    contexts: Annotated[dict[Name, Context], Field(min_length=1)]
    """Ways to begin an episode, by name."""
    disturbance: Disturbance = Disturbance.model_construct()
    world: WorldSection = WorldSection.model_construct()

    @classmethod
    def is_for_any_robot(cls, data: object) -> bool:
        """Return whether the values of a document may be in terms of a robot that it lacks."""
        return isinstance(data, dict) and data.get("robot") == ANY_ROBOT

    @model_validator(mode="after")
    def _takes_turns_in_a_persistent_world(self) -> Self:
        shown = [each for c in self.contexts.values() for each in c.presentations.values()]
        if not self.world.persistent and any(each.takes_turns for each in shown):
            raise ValueError("things come and move from turn to turn of a `persistent` world only")
        return self


def empty_stage(robot: str) -> StageDocument:
    """Return a stage for a robot on which there is nothing."""
    return StageDocument(
        cbdsl=1, kind="stage", name="empty", robot=robot, contexts={"still": Context()}
    )


STAGE = Kind(
    StageDocument,
    folder="programs/stages",
    checker="cbdsl.checking.stage.stage:examine_stage",
    unknown="CB602",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "contexts": {"unknown": {}}},
)
