"""The program document: controllers, actions and a policy over predicate states."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.documents.document import (
    Angle,
    AnyAcceleration,
    AnySpeed,
    Document,
    Duration,
    Length,
    Name,
    Number,
    Positive,
    PositiveCount,
    Rate,
    Section,
)
from cbdsl.documents.robot import Quiescence

Text = str
"""A resource, a reference literal or a composition; the checker parses it."""


class Standoff(Section):
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


class Funnel(Section):
    """Come to the reference from above: raised in proportion to the lateral error."""

    height: Length
    """Largest height above the reference."""
    within: Length
    """Lateral error below which the reference is not raised."""
    slope: Positive = 4.0
    """Height per lateral error."""


class Seek(Section):
    """When a controller acts although its feedback is undefined, as to find contact."""

    once: Text | None = None
    """Only after this controller, written as in ``actions``, came ``within`` of its reference."""
    within: Length = 0.02
    """How near ``once`` has to be."""
    until: Angle | None = None
    """Angle of the flexing joints past which nothing will be found."""


class Controller(Section):
    """A typed triple c(phi, sigma, tau)."""

    parameters: tuple[Name, ...] = ()
    """Names that a call such as ``reach(sat_10, right_arm)`` binds, in order."""
    potential: Name
    """The artificial potential phi."""
    feedback: Text
    """The resource sigma that is measured."""
    reference: Text | tuple[Text | Number, ...] | Number | None = None
    """What the feedback is compared with: a resource, or a literal such as ``[0 deg, 0 deg]``."""
    effector: Text
    """The resource tau that is moved."""
    gain: Rate | None = None
    """kappa, 1/s; without it the robot's setting for the feedback's type."""
    speed: AnySpeed | None = None
    """Largest rate of the task; without it the robot's setting for the feedback's type."""
    acceleration: AnyAcceleration | None = None
    """Largest acceleration of the task; without it the robot's setting."""
    quiescence: Quiescence | None = None
    free_axis: Literal["x", "y", "z"] | None = None
    """Axis of the tip about which an orientation may turn freely."""
    manipulator: Literal["position", "pose"] | None = None
    """Which Jacobian of the tip a manipulability is of; of its position without it."""
    standoff: Standoff | None = None
    funnel: Funnel | None = None
    seek: Seek | None = None


class Use(Section):
    """A program that is used as an action."""

    program: Name
    """Name of the program."""
    with_: Annotated[dict[Name, str], Field(alias="with")] = {}
    """Values of its parameters; ``$name`` refers to this program's own."""


class Limits(Section):
    """When an episode or a transition is given up."""

    transitions: PositiveCount = 100
    """T of Algorithm 1, in state transitions."""
    transition_time: Duration = 20.0
    """Simulated time that one action may run without a change of state."""


class ProgramDocument(Document):
    """A behaviour: what is wanted, and which action follows which state."""

    kind: Literal["program"]
    """Says that this document is a program."""
    robot: Name
    """Robot that it is for."""
    stage: Name | None = None
    """Training context used unless another is named."""
    parameters: dict[Name, str] = {}
    """Names that resources and compositions may refer to as ``$name``, with defaults."""
    use: dict[Name, Use] = {}
    """Other programs, usable as actions."""
    controllers: dict[Name, Controller | Text]
    """Triples, or compositions of them that are used as one controller."""
    background: Text | None = None
    """Composition that runs below every action with what freedom is left."""
    actions: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Controllers, compositions of controllers, or programs."""
    policy: dict[str, Text] = {}
    """Action by state: one of X - 0 1, or * for any, per controller and program of ``actions``."""
    limits: Limits = Limits.model_construct()
