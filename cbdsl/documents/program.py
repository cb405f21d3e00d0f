"""The program document: controllers, actions and a policy over predicate states."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticKnownError

from cbdsl.documents.document import (
    AnyAcceleration,
    AnyGain,
    AnySpeed,
    Coordinate,
    Distance,
    Document,
    Duration,
    Extent,
    Length,
    Name,
    Number,
    Positive,
    PositiveCount,
    Section,
    Speed,
    Tolerance,
    quantity,
)
from cbdsl.documents.kind import Kind
from cbdsl.documents.robot import QuiescenceSection

Text = str
"""A resource, a reference literal or a composition; the checker parses it."""


class StandoffSection(Section):
    """Keep the tip in front of its reference along the tip's own normal (+z).

    The distance is the seen radius of the reference plus ``clearance``, within ``least`` and
    ``most``.
    """

    clearance: Length
    """Distance between the tip and the surface that is seen."""
    least: Length
    """Smallest distance between the tip and the reference."""
    most: Length
    """Largest distance between the tip and the reference."""


class FunnelSection(Section):
    """Come to the reference from above: raised in proportion to the lateral error."""

    height: Length
    """Largest height above the reference."""
    within: Length
    """Lateral error below which the reference is not raised."""
    slope: Positive = 4.0
    """Height per lateral error."""


class SeekSection(Section):
    """When a controller acts although its feedback is undefined, as to find contact."""

    once: Text | None = None
    """Only after this controller, written as in ``actions``, came ``within`` of its reference.
    Its composition is not at rest during the search; its rest is judged at the end."""
    within: Length = 0.02
    """How near ``once`` has to be."""
    until: Coordinate | None = None
    """Angle of the flexing joints past which nothing will be found."""


class OnsetSection(Section):
    """Change of a load that makes a controller defined, as when a held object touches down.

    The load is compared with its own mean from the activation on. That mean is the weight of the
    held object while the object touches nothing else.
    """

    change: Tolerance
    """Smallest change towards the reference."""
    window: Duration = 0.05
    """For how long it has to last."""
    pace: Speed = 0.1
    """Speed of the hand above which no change counts: a load that is accelerated changes, too."""
    borne: Tolerance | None = None
    """Smallest load that the hand alone bears against the change before it, such as the weight of
    an object that hangs in it; a hand that presses on a table, or drags an object, has none."""
    lifted: Length = 0.0
    """How far the hand has to have carried that load against the change, as when it lifted an
    object that is then put down."""


class ObstacleSection(Section):
    """An obstacle of a motion: a ball around a resource, or a box that stays."""

    center: Text | None = None
    """Resource of the feedback's type, such as the tip of another arm."""
    radius: Extent | None = None
    """Radius around ``center``; without it the radius that is seen."""
    lower: tuple[Coordinate, ...] | None = None
    """Lower corner of a box."""
    upper: tuple[Coordinate, ...] | None = None
    """Upper corner of a box."""
    shaft: Extent | None = None
    """Half of the free width around the goal along the first two axes, in addition to the
    clearance: objects on a table are then approached from above."""

    @model_validator(mode="after")
    def _is_a_ball_or_a_box(self) -> Self:
        is_box = self.lower is not None and self.upper is not None
        is_half_a_box = (self.lower is None) != (self.upper is None)
        has_radius_alone = self.radius is not None and self.center is None
        if is_half_a_box or has_radius_alone or is_box == (self.center is not None):
            raise ValueError("an obstacle needs either a center, or lower and upper corners")
        if self.shaft is not None and not is_box:
            raise ValueError("only a box has a shaft")
        return self


class FieldSection(Section):
    """Workspace and obstacles of a harmonic function."""

    lower: tuple[Coordinate, ...] | None = None
    """Lower corner of the workspace; without it the lower limits of the joints."""
    upper: tuple[Coordinate, ...] | None = None
    """Upper corner of the workspace; without it the upper limits of the joints."""
    spacing: Extent
    """Distance between neighbours on the grid that the function is computed on."""
    scale: Extent = 0.1
    """Displacement that is asked for where the function is 1, far from the goal."""
    clearance: Distance = 0.0
    """Distance kept from obstacles, for all of the body that surrounds the feedback."""
    obstacles: tuple[ObstacleSection | Text, ...] = ()
    """Resources of the feedback's type, with the radius that is seen, or balls and boxes."""


Axis = Annotated[Text, Field(json_schema_extra={"pattern": r"^([xyz]|\$[A-Za-z][A-Za-z0-9_]*)$"})]
"""An axis of the world frame, or a parameter that stands for one."""


class ControllerSection(Section):
    """A typed triple c(phi, sigma, tau)."""

    renamed: ClassVar[Mapping[str, str]] = {"given": "requires"}

    parameters: tuple[Name, ...] = ()
    """Names that a call such as ``reach(sat_10, right_arm)`` binds, in order."""
    potential: Name
    """The artificial potential phi."""
    feedback: Text
    """The resource sigma that is measured."""
    reference: Text | tuple[Text | Number, ...] | Number | None = None
    """The reference rho: a resource, a literal such as ``[0 deg, 0 deg]``, or either ``here``, the
    feedback's value at activation, or a resource displaced by a literal in the world frame:
    ``here + [0 cm, 0 cm, 15 cm]``."""
    effector: Text
    """The resource tau that is moved."""
    gain: AnyGain | None = None
    """kappa, 1/s; without it the robot's setting for the feedback's type."""
    speed: AnySpeed | None = None
    """Largest rate of the task; without it the robot's setting for the feedback's type."""
    acceleration: AnyAcceleration | None = None
    """Largest acceleration of the task; without it the robot's setting."""
    quiescence: QuiescenceSection | None = None
    free_axis: Literal["x", "y", "z"] | None = None
    """Axis of the tip about which an orientation may turn freely, or that looks at a point."""
    axes: tuple[Axis, ...] | None = None
    """Axes of the world frame along which a position, force or torque is compared, or parameters
    that stand for them; all without it. The reference has one component for each."""
    manipulator: Literal["position", "pose"] | None = None
    """Which Jacobian of the tip a manipulability is of; of its position without it."""
    standoff: StandoffSection | None = None
    funnel: FunnelSection | None = None
    seek: SeekSection | None = None
    requires: Text | None = None
    """Undefined without this controller, written as in ``actions``: acts while that controller
    is defined or seeks. Manipulation needs a hand that holds the object."""
    onset: OnsetSection | None = None
    """Undefined until the load has changed; for a force or torque whose reference is ``here``."""
    field: FieldSection | None = None
    modifiers: dict[Name, dict[Name, Text | Number]] = {}
    """Changes of the reference in every tick, in turn, by kinds that other packages add; with the
    options of each."""

    @field_validator("reference")
    @classmethod
    def _is_no_list_in_a_text(cls, value: object) -> object:
        for text in value if isinstance(value, tuple) else (value,):
            if isinstance(text, str) and _may_be_several(text):
                _refuse_several(text)
        return value


def _may_be_several(text: str) -> bool:
    """Whether a text may hold more than one quantity."""
    numbers = (word for word in text.split() if word.lstrip("+-.")[:1].isdigit())
    return "," in text or text[:1] in ("[", "(") or len(list(numbers)) > 1


def _refuse_several(text: str) -> None:
    from cbdsl.types.quantity_slip import quantities_in  # only a fault needs it

    if len(parts := quantities_in(text)) > 1:
        row = ", ".join(parts)
        raise ValueError(f"a list is written in brackets, without quotes; write [{row}]")


class Use(Section):
    """A program that is used as an action."""

    program: Name
    """Name of the program."""
    with_: Annotated[dict[Name, str], Field(alias="with")] = {}
    """Values of its parameters; ``$name`` refers to this program's own."""
    policy: Name | None = None
    """Learned policy that replaces the written one."""
    schema_: Annotated[Name | None, Field(alias="schema")] = None
    """Schema that chooses its resources, with a policy of its own."""


class Limits(Section):
    """When an episode or a transition is given up."""

    transitions: PositiveCount = 100
    """T of Algorithm 1, in state transitions."""
    transition_time: Duration = 20.0
    """Simulated time that one action may run without a change of state."""
    idle_time: Duration | None = None
    """The same while no predicate of the state is 0 and nothing is sought, if that is less."""
    episode_time: Duration | None = None
    """Simulated time after which an episode ends in any case."""
    lost_time: Duration | None = None
    """Simulated time after which a program fails whose object was seen, and is remembered nowhere:
    not in view, and neither behind a hand nor where no camera looks."""
    reward_ends: bool = True
    """Whether the first reward ends an episode. While it is learned from, it always does."""


class GuardsSection(Section):
    """Bounds on contact forces, to which a program's motion gives way."""

    finger_force: Annotated[float, quantity("force", gt=0)] | None = None
    """Largest force of a fingertip, in all directions together."""
    hand_force: Annotated[float, quantity("force", gt=0)] | None = None
    """Largest net force of a hand."""
    joint_torque: Annotated[float, quantity("torque", gt=0)] | None = None
    """Largest torque, of all joints of an arm together, that contacts anywhere on it may cause."""


# Stands for a key that is not there; nothing that can be written equals it.
_ABSENT: Any = object()


def _required_without_use(value: Any, info: ValidationInfo) -> Any:
    """Let a program that uses others have no controllers of its own."""
    if value is not _ABSENT:
        return value
    if not info.data.get("use", True):
        raise PydanticKnownError("missing")
    return {}


class ProgramDocument(Document):
    """Behaviour: controllers, and a policy over their states."""

    kind: Literal["program"]
    """Says that this document is a program."""
    robot: Name
    """Robot that it is for."""
    stage: Name | None = None
    """Training context used unless another is named."""
    parameters: dict[Name, str] = {}
    """Names that resources and compositions may refer to as ``$name``, with defaults."""
    resources: dict[Name, Annotated[dict[Name, Text], Field(min_length=1)]] = {}
    """Kinds of resources that parameters may stand for, such as ``effector of position``; those in
    one group are replaced together, as an arm with its hand."""
    use: dict[Name, Use] = {}
    """Other programs, usable as actions."""
    models: dict[Name, Name] = {}
    """Internal models that references can be drawn from, as ``<effector>.<name>``."""
    controllers: Annotated[
        dict[Name, ControllerSection | Text],
        Field(default_factory=lambda: _ABSENT, validate_default=True),
        BeforeValidator(_required_without_use),
    ]
    """Triples, or compositions of them that are used as one controller; needed without ``use``."""
    background: Text | None = None
    """Composition that runs below every action, with the remaining freedom."""
    actions: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Controllers, compositions of controllers, or programs."""
    policy: dict[str, Text] = {}
    """Action by state: one of X - 0 1, or * for any, per controller and program of ``actions``."""
    success: tuple[str, ...] = ()
    """Patterns of states in which the program has succeeded and ends."""
    failure: tuple[str, ...] = ()
    """Patterns of states in which it has failed and ends."""
    rewards: dict[Name, tuple[Text, ...]] = {}
    """By composition that is used as one controller, those of its parts that have to be at rest for
    a reward: at least one that reads the environment, and others as conditions."""
    guards: GuardsSection = GuardsSection.model_construct()
    limits: Limits = Limits.model_construct()


PROGRAM = Kind(
    ProgramDocument,
    folder="programs",
    checker="cbdsl.checking.document:check_program",
    unknown="CB604",
    references={"robot": "robot"},
    stand_ins={"robot": "unknown", "controllers": {}, "actions": ["unknown"]},
)
