"""The program document: controllers, actions and a policy over predicate states."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    Field,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    field_validator,
    model_validator,
)
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
    """Distance of the tip from its reference along the tip's own normal (+z).

    The distance is the seen radius of the reference plus ``clearance``, within ``least`` and
    ``most``.
    """

    clearance: Length
    """Distance between the tip and the seen surface."""
    least: Length
    """Minimum distance between the tip and the reference."""
    most: Length
    """Maximum distance between the tip and the reference."""


class FunnelSection(Section):
    """Approach from above: the reference is raised in proportion to the lateral error."""

    height: Length
    """Maximum height above the reference."""
    within: Length
    """Lateral error below which the reference is not raised."""
    slope: Positive = 4.0
    """Height per lateral error."""


class SeekSection(Section):
    """Search of a controller while its feedback is undefined, as for contact."""

    once: Text | None = None
    """Controller, written as in ``actions``, that first has to come ``within`` of its reference.
    Its composition is not at rest during the search; its rest is judged at the end. If it moves to
    a seen object, forces of fingers count only at that object."""
    within: Length = 0.02
    """Maximum distance of ``once`` from its reference."""
    until: Coordinate | None = None
    """Angle of the flexing joints that ends the search."""


class OnsetSection(Section):
    """Change of a load that makes a controller defined, as when a held object touches down.

    The load is compared with its own mean since the activation. That mean is the weight of the held
    object while the object touches nothing else.
    """

    change: Tolerance
    """Minimum change towards the reference."""
    window: Duration = 0.05
    """Minimum duration of the change."""
    pace: Speed = 0.1
    """Speed of the hand above which changes are ignored, because acceleration also changes the
    load."""
    borne: Tolerance | None = None
    """Minimum load against the change that the hand alone bears before it, such as the weight of a
    hanging object. A hand that presses on a table, or drags an object, bears none."""
    lifted: Length = 0.0
    """Minimum distance by which the hand has carried that load against the change, as when it
    lifted an object before putting it down."""


class ObstacleSection(Section):
    """Obstacle of a motion: a ball around a resource, or a fixed box."""

    center: Text | None = None
    """Resource of the feedback's type, such as the tip of another arm."""
    radius: Extent | None = None
    """Radius around ``center``; the seen radius if omitted."""
    lower: tuple[Coordinate, ...] | None = None
    """Lower corner of a box."""
    upper: tuple[Coordinate, ...] | None = None
    """Upper corner of a box."""
    shaft: Extent | None = None
    """Half of the free width around the goal along the first two axes, in addition to the
    clearance: objects on a table are then approached from above."""

    @model_validator(mode="after")
    def _is_a_ball_or_a_box(self) -> Self:
        # Neither ``{lower: [...]}`` alone nor a radius without a center determines a shape.
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
    """Lower corner of the workspace; the lower limits of the joints if omitted."""
    upper: tuple[Coordinate, ...] | None = None
    """Upper corner of the workspace; the upper limits of the joints if omitted."""
    spacing: Extent
    """Distance between neighbours on the grid of the function."""
    scale: Extent = 0.1
    """Requested displacement if the function is 1, far from the goal."""
    clearance: Distance = 0.0
    """Distance from obstacles that covers the body around the feedback."""
    obstacles: tuple[ObstacleSection | Text, ...] = ()
    """Resources of the feedback's type with their seen radius, or balls and boxes."""


Axis = Annotated[Text, Field(json_schema_extra={"pattern": r"^([xyz]|\$[A-Za-z][A-Za-z0-9_]*)$"})]
"""An axis of the world frame, or a parameter that stands for one."""


# A controller c(phi, sigma, tau) moves its effector tau so that the potential phi of its feedback
# sigma falls. Its law is Delta tau = -kappa J^# phi(sigma) with the task Jacobian J = d phi(sigma)
# / d tau (Eq 3.18). J^# is the pseudoinverse, and kappa the gain. Feedback and effector may be of
# different types, if casts connect them (Section 3.2.4). The keys below the triple are settings of
# this law, and conditions under which sigma or the reference counts as undefined.
class ControllerSection(Section):
    """Typed triple c(phi, sigma, tau)."""

    renamed: ClassVar[Mapping[str, str]] = {"given": "requires"}
    moved: ClassVar[Mapping[str, str]] = {
        "parameters": "shared documents have controllers with parameters; declare it in one, as "
        "`reach(arm): {...}`, and name it below 'shared'"
    }

    potential: Name
    """Artificial potential phi."""
    feedback: Text
    """Measured resource sigma."""
    reference: Text | tuple[Text | Number, ...] | Number | None = None
    """Reference rho: a resource, a literal such as ``[0 deg, 0 deg]``, or either ``here``, the
    feedback's value at activation, or a resource displaced by a literal in the world frame: ``here
    + [0 cm, 0 cm, 15 cm]``."""
    effector: Text
    """Moved resource tau."""
    gain: AnyGain | None = None
    """kappa, 1/s; the robot's setting for the feedback's type if omitted."""
    speed: AnySpeed | None = None
    """Maximum rate of the task; the robot's setting for the feedback's type if omitted."""
    acceleration: AnyAcceleration | None = None
    """Maximum acceleration of the task; the robot's setting if omitted."""
    arrival: Tolerance | Literal["rest"] | None = None
    """Maximum residual at which it has arrived when it is at rest, or `rest` if rest is enough; the
    tolerance of its quiescence or the robot's setting if omitted."""
    quiescence: QuiescenceSection | None = None
    free_axis: Literal["x", "y", "z"] | None = None
    """Axis of the tip about which an orientation may turn freely, or that points at a position."""
    axes: tuple[Axis, ...] | None = None
    """Axes of the world frame along which a position, force or torque is compared, or parameters
    that stand for them; all if omitted. The reference has one component for each."""
    manipulator: Literal["position", "pose"] | None = None
    """Jacobian of the tip that a manipulability is computed from; that of its position if
    omitted."""
    standoff: StandoffSection | None = None
    funnel: FunnelSection | None = None
    seek: SeekSection | None = None
    requires: Text | None = None
    """Controller, written as in ``actions``, that has to be defined or seeking; this one is
    undefined otherwise. Manipulation needs a hand that holds the object."""
    onset: OnsetSection | None = None
    """Load change that makes the controller defined; for a force or torque with the reference
    ``here``."""
    field: FieldSection | None = None
    modifiers: dict[Name, dict[Name, Text | Number]] = {}
    """Changes of the reference in every tick, in order, by kinds of other packages, with their
    options."""
    otherwise: Self | None = None
    """Controller in its place on a robot that lacks an optional role."""

    @field_validator("reference")
    @classmethod
    def _is_no_list_in_a_text(cls, value: object) -> object:
        for text in value if isinstance(value, tuple) else (value,):
            if isinstance(text, str) and _may_be_several(text):
                _refuse_several(text)
        return value


def _may_be_several(text: str) -> bool:
    """Return whether a text may hold more than one quantity."""
    # A cheap test that most references fail, such as ``sat_10`` or ``5 cm``. It admits ``1 cm, 2
    # cm`` in quotes, which YAML reads as one text.
    numbers = (word for word in text.split() if word.lstrip("+-.")[:1].isdigit())
    return "," in text or text[:1] in ("[", "(") or len(list(numbers)) > 1


def _refuse_several(text: str) -> None:
    from cbdsl.types.quantity_problem import quantities_in  # only a fault needs it

    if len(parts := quantities_in(text)) > 1:
        row = ", ".join(parts)
        raise ValueError(f"a list is written in brackets, without quotes; write [{row}]")


class Use(Section):
    """Program used as an action."""

    program: Name
    """Name of the program."""
    with_: Annotated[dict[Name, str], Field(alias="with")] = {}
    """Values of its parameters; ``$name`` refers to a parameter of this program."""
    policy: Name | None = None
    """Learned policy that replaces the written one."""
    schema_: Annotated[Name | None, Field(alias="schema")] = None
    """Schema that chooses its resources, with its own policy."""
    otherwise: Self | None = None
    """Use in its place on a robot that does not fill the roles of the program."""


class Limits(Section):
    """Limits of an episode and of a transition."""

    transitions: PositiveCount = 100
    """Maximum number of state transitions, T of Algorithm 1."""
    transition_time: Duration = 20.0
    """Maximum simulated time of one action without a change of state."""
    idle_time: Duration | None = None
    """The same while no predicate of the state is 0 and no controller seeks, if that is less."""
    episode_time: Duration | None = None
    """Maximum simulated time of an episode."""
    lost_time: Duration | None = None
    """Simulated time after which a program fails if its object was seen and is lost: neither in
    view, nor remembered behind a hand or outside of the view of the cameras."""
    reward_ends: bool = True
    """True if the first reward ends an episode; always true during learning."""


class GuardsSection(Section):
    """Bounds on contact forces and on distances of links; motion yields to them."""

    finger_force: Annotated[float, quantity("force", gt=0)] | None = None
    """Maximum force of a fingertip, over all directions."""
    hand_force: Annotated[float, quantity("force", gt=0)] | None = None
    """Maximum net force of a hand."""
    joint_torque: Annotated[float, quantity("torque", gt=0)] | None = None
    """Maximum torque of contacts anywhere on an arm, over all its joints."""
    clearance: Annotated[float, quantity("length", gt=0)] | None = None
    """Minimum distance between links of the robot."""
    avoid: tuple[Text, ...] = ()
    """Fixtures of the stage, and seen objects such as `stereo.red`, from which links keep the
    clearance, too."""


# Stands for a key that is not there; nothing that can be written equals it.
_ABSENT: Any = object()


def _required_without_alternative(
    value: Any, validate: ValidatorFunctionWrapHandler, info: ValidationInfo
) -> Any:
    """Require a key unless the document has a key that replaces it."""
    if value is not _ABSENT:
        return validate(value)
    # Fields are validated in order, and the other keys come first. If one is faulty, it is missing
    # here and counts as given, so that its fault is not reported a second time.
    others = ProgramDocument.alternatives[str(info.field_name)]
    if not any(info.data.get(other, True) for other in others):
        raise PydanticKnownError("missing")
    return {"controllers": {}, "actions": (), "robot": ""}[str(info.field_name)]


class StepSection(Section):
    """Step: an action, and exits to other steps; without an exit that holds, it goes on."""

    do: Text | None = None
    """Controller, composition or program; the one with the name of the step if omitted."""
    exits: tuple[Annotated[dict[Text, Text], Field(min_length=1, max_length=1)], ...] = ()
    """Conditions such as `lift undefined and heavy not at rest`, each with a target: a step,
    `succeed`, `fail` with a reason, or `end`. The first one that holds applies."""
    failed: Text | None = None
    """Target once a member is undefined or, if it is a program, has failed."""
    then: Text | None = None
    """Target once each member is at rest or, if it is a program, has succeeded."""


class ProgramDocument(Document):
    """Behaviour: controllers and a policy over their states."""

    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "robot": ("roles",),
        "actions": ("steps",),
        "controllers": ("use", "shared"),
    }

    kind: Literal["program"]
    """Kind of this document: a program."""
    roles: dict[Name, Text] = {}
    """Parts of any robot, in place of ``robot``, by name: `effector of force on arm`, `effector of
    position other than arm`; parameters stand for them."""
    robot: Annotated[
        Name,
        Field(default_factory=lambda: _ABSENT, validate_default=True),
        WrapValidator(_required_without_alternative),
    ]
    """Robot of the program; required without ``roles``."""
    stage: Name | None = None
    """Stage to run on, unless another one is named."""
    stages: tuple[Name, ...] = ()
    """Stages of other robots, in place of ``stage``: the first one that suits the robot."""
    parameters: dict[Name, str] = {}
    """Names that resources and compositions may refer to as ``$name``, with default values."""
    resources: dict[Name, Annotated[dict[Name, Text], Field(min_length=1)]] = {}
    """Kinds of resources for parameters, such as ``effector of position``; those in one group are
    replaced together, as an arm with its hand."""
    use: dict[Name, Use] = {}
    """Other programs, available as actions."""
    shared: dict[Name, tuple[Name, ...]] = {}
    """Controllers and conditions that it takes up and calls by name, by their shared documents."""
    models: dict[Name, Name] = {}
    """Internal models to draw references from, as ``<effector>.<name>``."""
    meta_catalog: Name | None = None
    """Meta-catalog whose pairs are recognised by ``likeness.<pair>``."""
    controllers: Annotated[
        dict[Name, ControllerSection | Text],
        Field(default_factory=lambda: _ABSENT, validate_default=True),
        WrapValidator(_required_without_alternative),
    ]
    """Triples, or compositions that act as one controller; required without ``use`` and
    ``shared``."""
    conditions: dict[Name, Text] = {}
    """Comparisons of signals and quantities, joined by `and`, `or` and `not`, such as
    `$hand.net.force.z < -7 N for 0.3 s`. Exits of steps name them; without steps, each is a letter
    of the state."""
    background: Text | None = None
    """Composition that runs below every action in the remaining degrees of freedom."""
    steps: dict[Name, StepSection] = {}
    """Steps with their exits, in place of ``policy``, ``success`` and ``failure``."""
    start: Name | None = None
    """First step; the first one of ``steps`` if omitted."""
    actions: Annotated[
        tuple[Text, ...],
        Field(min_length=1, default_factory=lambda: _ABSENT, validate_default=True),
        WrapValidator(_required_without_alternative),
    ]
    """Controllers, compositions of controllers, or programs; beside ``steps``, further ones."""
    policy: dict[str, Text] = {}
    """Action by state: one of X - 0 1, or * for any, per controller and program of ``actions``."""
    success: tuple[str, ...] = ()
    """Patterns of states in which the program succeeds and ends."""
    failure: tuple[str, ...] | dict[str, str] = ()
    """Patterns of states in which the program fails and ends, or a reason for each, as a clause."""
    rewards: dict[Name, tuple[Text, ...]] = {}
    """Parts of a composed controller that must be at rest for a reward, by its name: at least one
    that reads the environment, and others as conditions."""
    guards: GuardsSection = GuardsSection.model_construct()
    limits: Limits = Limits.model_construct()

    @classmethod
    def is_for_any_robot(cls, data: object) -> bool:
        """Return whether the values of a document may be in terms of a robot that it lacks."""
        return isinstance(data, dict) and "roles" in data

    @property
    def assignable(self) -> dict[str, str]:
        """Parameters and roles, to which a user of the program may assign values, by name."""
        return {**self.roles, **self.parameters}


PROGRAM = Kind(
    ProgramDocument,
    folder="programs",
    checker="cbdsl.checking.document:check_program",
    unknown="CB604",
    references={"robot": "robot", "meta_catalog": "meta_catalog"},
    stand_ins={"robot": "unknown", "controllers": {}, "actions": ["unknown"]},
)
