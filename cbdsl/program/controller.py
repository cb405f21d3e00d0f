"""Checked controllers and the stacks that compose them."""

from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.types.resource import Resource


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


Reference = Resource | Literal | AlongNormals


class Quiescence(NamedTuple):
    """When phi counts as at rest (Eq 4.1).

    Attributes:
        rate: largest range of phi over the window, per second of the window.
        window: s.
        within: largest residual that earns a reward, as a share of the reference's norm.
        tolerance: largest residual that earns a reward, in the feedback's unit.
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
    """Acting while the feedback is undefined; within in m, until in rad."""

    once: str | None
    within: float
    until: float | None


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
        chain: the types and casts that lead from the feedback to the effector, for people.
        rewarded: whether its quiescence is an affordance (feedback from the environment).
        gain: kappa, 1/s.
        speed: largest rate of the task coordinates, or ``None``.
        acceleration: largest acceleration of the task coordinates, or ``None``.
        manipulator: ``position`` or ``pose``, where phi is a function of that Jacobian of the tip.
    """

    name: str
    potential: str
    feedback: Resource
    reference: Reference | None
    effector: Resource
    joints: tuple[str, ...]
    chain: tuple[str, ...]
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


class Primitive(NamedTuple):
    """What a state has one predicate for: one controller, or several composed into one.

    Attributes:
        name: as the program calls it, with its arguments.
        controllers: in written order; the last has priority and gives the predicate.
    """

    name: str
    controllers: tuple[Controller, ...]

    @property
    def lead(self) -> Controller:
        """The controller with the highest priority."""
        return self.controllers[-1]


class Composition(NamedTuple):
    """``c2 ◁ c1``: primitives in written order, the last one with the highest priority."""

    primitives: tuple[Primitive, ...]

    def __str__(self) -> str:
        return " ◁ ".join(primitive.name for primitive in self.primitives)
