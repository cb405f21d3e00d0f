"""Checked controllers and the stacks that compose them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.types.casts import Chain
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES, ResourceType


# Notation of Chapter 3: a controller c(phi, sigma, tau) descends a potential phi of the signals
# sigma by moving the effector tau. The composition c2 ◁ c1, "c2 subject to c1", runs c2 in the null
# space of c1. Lists keep this written order, so that the last controller has the highest priority.
# A primitive is one letter of a state, independently of the number of its controllers.
class Literal(NamedTuple):
    """Constant reference, in SI.

    Attributes:
        values: One number per component of the feedback.
    """

    values: tuple[float, ...]


class AlongNormals(NamedTuple):
    """Force reference along each finger's normal, to be shared among the fingers.

    Attributes:
        force: N, before each finger's share is applied.
    """

    force: float


class Relative(NamedTuple):
    """Reference displaced from a resource, or from the feedback at activation.

    Attributes:
        base: Resource; ``None`` for the value of the feedback at activation, which programs
            call ``here``.
        offset: Offset in SI, one number per component of the feedback. It is added in the world
            frame; an orientation is turned by a rotation vector in world axes.
    """

    base: Resource | None
    offset: tuple[float, ...]

    def __str__(self) -> str:
        base = "here" if self.base is None else self.base.name
        if not any(self.offset):
            return base
        return f"{base} + {', '.join(f'{value:g}' for value in self.offset)}"


Reference = Resource | Literal | AlongNormals | Relative


class Quiescence(NamedTuple):
    """Criterion for phi to count as at rest (Eq 4.1).

    Attributes:
        rate: Largest range of phi over the window, per second of the window.
        window: Duration of the window, s.
        within: Largest residual at rest, as a share of the reference's norm.
        tolerance: Largest residual at rest, in the feedback's unit.
    """

    rate: float
    window: float
    within: float | None = None
    tolerance: float | None = None


class Standoff(NamedTuple):
    """Distance kept in front of the reference along the tip's normal, m."""

    clearance: float
    least: float
    most: float


class Funnel(NamedTuple):
    """Approach from above; ``height`` and ``within`` in m."""

    height: float
    within: float
    slope: float


class Seek(NamedTuple):
    """Action while the feedback is undefined; ``within`` in m, ``until`` in rad or m."""

    once: str | None
    within: float
    until: float | None


class Onset(NamedTuple):
    """Required change of a load, before which a controller is undefined.

    Attributes:
        change: Change of the filtered load since activation, towards the reference, N or N m.
        window: Minimum duration of the change, s.
        pace: Speed of the hand above which no change counts, m/s.
        borne: Smallest load against the change before it, N or N m; ``None`` for any.
        lifted: Distance by which the hand has carried that load against the change, m.
    """

    change: float
    window: float
    pace: float
    borne: float | None = None
    lifted: float = 0.0


class Box(NamedTuple):
    """Box that a motion keeps away from.

    Attributes:
        name: Name of the box in messages.
        lower, upper: Corners in SI, one number per component.
        shaft: Half of the width, along the first two axes, that stays free around the goal, in SI;
            ``None`` for none.
    """

    name: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    shaft: float | None = None


class Ball(NamedTuple):
    """Neighbourhood of a resource that a motion keeps away from.

    Attributes:
        resource: Resource at the centre.
        radius: Radius in SI; ``None`` for the perceived radius.
    """

    resource: Resource
    radius: float | None


class Field(NamedTuple):
    """Domain of a harmonic function (Eq 3.2), in SI.

    Attributes:
        lower, upper: Corners of the workspace; ``None`` for the limits of the joints.
        spacing: Spacing of the grid.
        scale: Displacement for phi = 1 (Eq 7.1).
        clearance: Distance kept from obstacles.
        obstacles: Obstacles to avoid.
    """

    lower: tuple[float, ...] | None
    upper: tuple[float, ...] | None
    spacing: float
    scale: float
    clearance: float
    obstacles: tuple[Box | Ball, ...]


class Modifier(NamedTuple):
    """Change of the reference in every tick; options by name, in SI."""

    name: str
    options: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Controller:
    """Checked triple c(phi, sigma, tau).

    Attributes:
        name: Name in the program and in messages.
        potential: Name in the registry of potentials.
        feedback: Measured resource.
        reference: Reference of the feedback; ``None`` if the potential needs none.
        effector: Moved resource.
        joints: Actuated joints that move the effector.
        chains: Casts that lead from the feedback to these joints; their contributions add up.
        rewarded: True if its quiescence is an affordance (feedback from the environment).
        gain: Gain kappa, 1/s.
        speed: Largest rate of the task coordinates, or ``None``.
        acceleration: Largest acceleration of the task coordinates, or ``None``.
        manipulator: ``position`` or ``pose``, if phi is a function of that Jacobian of the tip.
        modifiers: Changes of the reference, in order.
        requires: Name of the controller without which it is undefined, or ``None``.
        axes: Indices of the compared world axes, of every factor; ``None`` for all.
        onset: Change of the load that is required before it is defined, or ``None``.
        tip_stiffness: Stiffness under a tip, N/m, if the speed of a force is the tip's, m/s;
            ``None`` for all others.
        joint_unit: Units of its joints' positions, as of a configuration's type.
        arrival: Largest residual at which it has arrived when it is at rest: one number, or one for
            each unit of the task; infinite if rest is enough.
    """

    name: str
    potential: str
    feedback: Resource
    reference: Reference | None
    effector: Resource
    joints: tuple[str, ...]
    chains: tuple[Chain, ...]
    rewarded: bool
    gain: float
    speed: float | None
    acceleration: float | None
    quiescence: Quiescence
    free_axis: str | None = None
    manipulator: str | None = None
    standoff: Standoff | None = None
    funnel: Funnel | None = None
    seek: Seek | None = None
    requires: str | None = None
    field: Field | None = None
    modifiers: tuple[Modifier, ...] = ()
    axes: tuple[int, ...] | None = None
    onset: Onset | None = None
    tip_stiffness: float | None = None
    joint_unit: str = "rad"
    arrival: tuple[float, ...] = (math.inf,)

    @property
    def task(self) -> ResourceType:
        """Resource type of its error, which determines the units of its gain and bounds."""
        name = POTENTIALS[self.potential].task
        return self.feedback.type if name is None else TYPES[name]

    @property
    def compared(self) -> ResourceType:
        """Resource type of its reference."""
        name = POTENTIALS[self.potential].compares
        return self.feedback.type if name is None else TYPES[name]

    @property
    def is_drawn(self) -> bool:
        """True if its reference is drawn at activation, from an internal model or a surface."""
        return isinstance(self.reference, Resource) and self.reference.is_drawn

    @property
    def resources(self) -> tuple[Resource, ...]:
        """Resources that it reads."""
        obstacles = self.field.obstacles if self.field is not None else ()
        compared = self.reference.base if isinstance(self.reference, Relative) else self.reference
        reference = (compared,) if isinstance(compared, Resource) else ()
        balls = tuple(o.resource for o in obstacles if isinstance(o, Ball))
        return (self.feedback, *reference, *balls)


class Primitive(NamedTuple):
    """Members of a state with one predicate: one controller, or several composed into one.

    Attributes:
        name: Name in the program, with its arguments.
        controllers: Controllers in written order; the last has priority and gives the predicate.
        earning: Names of the controllers whose quiescence is rewarded although they were composed,
            and of the controllers that have to be at rest for it.
    """

    name: str
    controllers: tuple[Controller, ...]
    earning: tuple[str, ...] = ()

    @property
    def lead(self) -> Controller:
        """Return the controller with the highest priority."""
        return self.controllers[-1]

    @property
    def rewarded(self) -> bool:
        """True if its quiescence can be rewarded.

        Controllers composed into one are used as a whole, as programs are, and are habituated
        like them (Section 4.3), unless their program states the rewarded parts.
        """
        return bool(self.earners)

    @property
    def earners(self) -> tuple[Controller, ...]:
        """Controllers whose rest is rewarded once all are at rest; empty if there are none."""
        if len(self.controllers) == 1:
            return self.controllers if self.lead.rewarded else ()
        return tuple(each for each in self._named if each.rewarded)

    @property
    def conditions(self) -> tuple[Controller, ...]:
        """Controllers that have to be at rest for a reward, and earn none."""
        return tuple(each for each in self._named if not each.rewarded)

    @property
    def _named(self) -> tuple[Controller, ...]:
        return tuple(each for each in self.controllers if each.name in self.earning)


class Composition(NamedTuple):
    """``c2 ◁ c1``: primitives in written order, the last one with the highest priority."""

    primitives: tuple[Primitive, ...]

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """Controllers of all primitives, in written order."""
        return tuple(each for primitive in self.primitives for each in primitive.controllers)

    def __str__(self) -> str:
        return " ◁ ".join(primitive.name for primitive in self.primitives)
