"""Checked controllers and the stacks that compose them."""

from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.types.casts import Chain
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import TYPES, ResourceType


class Literal(NamedTuple):
    """A constant reference, in SI.

    Attributes:
        values: one number per component of the feedback.
    """

    values: tuple[float, ...]


class AlongNormals(NamedTuple):
    """A force reference along each finger's normal, to be shared among the fingers.

    Attributes:
        force: N, before each finger's share is applied.
    """

    force: float


class Relative(NamedTuple):
    """A reference that is displaced from a resource, or from where the feedback was at activation.

    Attributes:
        base: the resource; ``None`` for the value of the feedback at activation, which programs
            call ``here``.
        offset: in SI, one number per component of the feedback. It is added in the world frame;
            an orientation is turned by a rotation vector in world axes.
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
    """When phi counts as at rest (Eq 4.1).

    Attributes:
        rate: largest range of phi over the window, per second of the window.
        window: s.
        within: largest residual at rest, as a share of the reference's norm.
        tolerance: largest residual at rest, in the feedback's unit.
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
    """Approach from above; height and within in m."""

    height: float
    within: float
    slope: float


class Seek(NamedTuple):
    """Acting while the feedback is undefined; within in m, until in rad or m."""

    once: str | None
    within: float
    until: float | None


class Onset(NamedTuple):
    """Waiting for a load to change, before which a controller is undefined.

    Attributes:
        change: of the filtered load since the activation, towards the reference, N or N m.
        window: for how long it has to last, s.
        pace: speed of the hand above which no change counts, m/s.
        borne: smallest load against the change before it, N or N m; ``None`` for any.
        lifted: distance by which the hand has carried that load against the change, m.
    """

    change: float
    window: float
    pace: float
    borne: float | None = None
    lifted: float = 0.0


class Box(NamedTuple):
    """A box that a motion keeps away from.

    Attributes:
        name: what messages call it.
        lower, upper: corners in SI, one number per component.
        shaft: half of the width, along the first two axes, that stays free around the goal, in SI;
            ``None`` for none.
    """

    name: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    shaft: float | None = None


class Ball(NamedTuple):
    """Everything near a resource that a motion keeps away from.

    Attributes:
        resource: the centre.
        radius: in SI; ``None`` for the radius that is seen.
    """

    resource: Resource
    radius: float | None


class Field(NamedTuple):
    """Where a harmonic function is computed (Eq 3.2), in SI.

    Attributes:
        lower, upper: corners of the workspace; ``None`` for the limits of the joints.
        spacing: of the grid.
        scale: displacement for phi = 1 (Eq 7.1).
        clearance: distance kept from obstacles.
        obstacles: what to keep away from.
    """

    lower: tuple[float, ...] | None
    upper: tuple[float, ...] | None
    spacing: float
    scale: float
    clearance: float
    obstacles: tuple[Box | Ball, ...]


class Modifier(NamedTuple):
    """A change of the reference in every tick; options by name, in SI."""

    name: str
    options: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Controller:
    """A checked triple c(phi, sigma, tau).

    Attributes:
        name: as the program and messages call it.
        potential: name in the registry of potentials.
        feedback: the measured resource.
        reference: what it is compared with; ``None`` where the potential needs none.
        effector: the moved resource.
        joints: the actuated joints that move it.
        chains: the casts that lead from the feedback to these joints; what they carry adds up.
        rewarded: whether its quiescence is an affordance (feedback from the environment).
        gain: kappa, 1/s.
        speed: largest rate of the task coordinates, or ``None``.
        acceleration: largest acceleration of the task coordinates, or ``None``.
        manipulator: ``position`` or ``pose``, where phi is a function of that Jacobian of the tip.
        modifiers: changes of the reference, in turn.
        requires: name of the controller without which it is undefined, or ``None``.
        axes: indices of the world axes that are compared, of every factor; ``None`` for all.
        onset: how the load has to change before it is defined, or ``None``.
        tip_stiffness: of what a tip presses on, N/m, where the speed of a force is the tip's, m/s;
            ``None`` for all others.
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

    @property
    def task(self) -> ResourceType:
        """The type whose unit its error has, and its gain and bounds are of."""
        name = POTENTIALS[self.potential].task
        return self.feedback.type if name is None else TYPES[name]

    @property
    def compared(self) -> ResourceType:
        """The type of its reference."""
        name = POTENTIALS[self.potential].compares
        return self.feedback.type if name is None else TYPES[name]

    @property
    def is_drawn(self) -> bool:
        """Whether its reference is drawn when it begins, from an internal model or a surface."""
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
        name: as the program calls it, with its arguments.
        controllers: in written order; the last has priority and gives the predicate.
        earning: names of those whose rest is rewarded although they were composed, and of those
            that have to be at rest for it.
    """

    name: str
    controllers: tuple[Controller, ...]
    earning: tuple[str, ...] = ()

    @property
    def lead(self) -> Controller:
        """The controller with the highest priority."""
        return self.controllers[-1]

    @property
    def rewarded(self) -> bool:
        """Whether its quiescence can be rewarded.

        What was composed into one controller is used as a whole, as programs are, and is habituated
        as they are (Section 4.3), unless its program says which of its parts are rewarded.
        """
        return bool(self.earners)

    @property
    def earners(self) -> tuple[Controller, ...]:
        """The controllers whose rest is rewarded once all are at rest; empty where none is."""
        if len(self.controllers) == 1:
            return self.controllers if self.lead.rewarded else ()
        return tuple(each for each in self._named if each.rewarded)

    @property
    def conditions(self) -> tuple[Controller, ...]:
        """The controllers that have to be at rest for a reward, and earn none."""
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
