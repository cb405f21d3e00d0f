"""Resources: the named, typed signals of one robot, and where each comes from."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.types.resource_type import ResourceType

if TYPE_CHECKING:
    from cbdsl.numeric.affordance import AffordanceModel

#: Beginning of the names of probabilities that a catalog predicts.
AFFORDS = "affords."


class Origin(Enum):
    """Where a signal arises (Eq 3.16); only ``ENVIRONMENT`` can be rewarded (Eq 4.3)."""

    ENVIRONMENT = "environment"
    PROPRIOCEPTION = "proprioception"
    KINEMATICS = "kinematics"
    TRIANGULATION = "triangulation"
    MODEL = "internal model"
    SURFACE = "visible surface"
    CONSTANT = "constant"


class EffectorConfiguration(NamedTuple):
    """The joint positions of an effector or a group."""

    effector: str


class Tip(NamedTuple):
    """The ``position``, ``orientation`` or ``pose`` of an effector's tip, in the world frame.

    Of a group: the positions of all tips.
    """

    effector: str
    part: str


class Centroid(NamedTuple):
    """The mean position of a group's tips, in the world frame (Section 3.3.3.2)."""

    group: str


class Separation(NamedTuple):
    """The position of the second tip of a group of two relative to the first, in world axes."""

    group: str


class FingerLoad(NamedTuple):
    """The ``force``, ``torque`` or ``wrench`` a finger exerts, in the world frame."""

    hand: str
    finger: str
    part: str


class NetLoad(NamedTuple):
    """The sum over a hand's fingers of their ``force``, ``torque`` or ``wrench``."""

    hand: str
    part: str


class NetForces(NamedTuple):
    """The net force of each hand of a group, in turn (Eq 3.34), or that of one hand."""

    group: str


def palms_of(source: object) -> NetForces | None:
    """Hands whose net forces have palms' normals, of a source that has such forces."""
    if isinstance(source, NetLoad) and source.part == "force":
        return NetForces(source.hand)
    return source if isinstance(source, NetForces) else None


class FingerForces(NamedTuple):
    """The forces of all fingers of a hand, in the order of the robot file."""

    hand: str


SELECTIONS = ("nearest", "largest", "leftmost", "rightmost", "other")
"""Instances of a channel that are selected among those remembered, at any moment anew.

Nearest to the cameras, with the largest radius, farthest to the left or right as the cameras' place
has it; or the nearest to the one attended to, apart from that. Others are numbered from 1 in the
order of discovery, and "" is the one attended to.
"""


class Heading(NamedTuple):
    """Where a camera sees a thing of a channel; ``cyclopean`` is the mean over the cameras."""

    camera: str
    channel: str
    instance: str = ""


class Headings(NamedTuple):
    """Where each camera sees a thing of a channel, camera by camera (Eq 3.14)."""

    channel: str
    instance: str = ""


class StereoPosition(NamedTuple):
    """The triangulated position of a thing of a channel, in the world frame (Eq 3.14)."""

    channel: str
    instance: str = ""


class BlobSignal(NamedTuple):
    """A part of the blob that a camera sees of a channel (Fig 7.15).

    Attributes:
        camera: its name.
        channel: whose region it is.
        part: ``velocity``, ``extent`` or ``orientation``.
        instance: which thing of the channel.
    """

    camera: str
    channel: str
    part: str
    instance: str = ""


class StereoSignal(NamedTuple):
    """The ``velocity`` or ``volume`` of what both cameras see of a channel (Section 5.3)."""

    channel: str
    part: str
    instance: str = ""


class ConstellationSignal(NamedTuple):
    """The constellation of two channels' blobs in a camera's image (Fig 7.15).

    Attributes:
        camera: its name.
        channel: whose blob is compared.
        other: whose blob it is compared with.
    """

    camera: str
    channel: str
    other: str


class StereoOffset(NamedTuple):
    """The position of what is seen of a channel relative to that of another one."""

    channel: str
    other: str


class InstanceCount(NamedTuple):
    """How many things of a channel are remembered."""

    channel: str


class SurfacePoint(NamedTuple):
    """A draw from the visible points of a surface that fills the images of a channel."""

    channel: str


class SensorSignal(NamedTuple):
    """A signal of a sensor of another package's kind, as a robot's document declares it.

    Attributes:
        sensor: its name in the document.
        kind: name of the kind.
        part: which of the sensor's signals.
        links: of the model, that carry it.
    """

    sensor: str
    kind: str
    part: str
    links: tuple[str, ...]


class Posture(NamedTuple):
    """A named joint posture of the robot file."""

    effector: str
    posture: str


class UniformSample(NamedTuple):
    """A draw from the uniform distribution between an effector's joint limits."""

    effector: str


class GaussianSample(NamedTuple):
    """A draw from normal distributions of an effector's joints, rad.

    A share of ``uniform`` of the draws is uniform between the joint limits instead.
    """

    effector: str
    mean: tuple[float, ...]
    deviation: tuple[float, ...]
    uniform: float = 0.0


class KernelSample(NamedTuple):
    """A draw from Gaussian kernels around configurations of an effector, rad.

    A share of ``uniform`` of the draws is uniform between the joint limits instead.
    """

    effector: str
    samples: tuple[tuple[float, ...], ...]
    bandwidth: tuple[float, ...]
    uniform: float = 0.0


class NovelHeading(NamedTuple):
    """Where the cameras see something of a channel that its background model does not expect.

    Attributes:
        channel: its name.
        effector: moves the cameras.
        expected: density of its configurations in which the channel was tracked.
    """

    channel: str
    effector: str
    expected: GaussianSample | KernelSample


class MarkHeading(NamedTuple):
    """Where the cameras see another hue on a thing than the thing's own.

    Attributes:
        channel: of the thing.
        hues: channels that the mark may be of.
    """

    channel: str
    hues: tuple[str, ...]


class AffordanceProbability(NamedTuple):
    """The probability that an action is rewarded, Pr(reward | f, a), as a catalog has it (6.1).

    Attributes:
        catalog: its name.
        action: one of its actions.
        model: of the action.
        features: resources of its features f, in the order of the model's components.
    """

    catalog: str
    action: str
    model: AffordanceModel
    features: tuple[Resource, ...]


Source = (
    EffectorConfiguration
    | Tip
    | Centroid
    | Separation
    | FingerLoad
    | NetLoad
    | NetForces
    | FingerForces
    | Heading
    | Headings
    | StereoPosition
    | BlobSignal
    | StereoSignal
    | ConstellationSignal
    | StereoOffset
    | InstanceCount
    | NovelHeading
    | MarkHeading
    | AffordanceProbability
    | SurfacePoint
    | SensorSignal
    | Posture
    | UniformSample
    | GaussianSample
    | KernelSample
)


_DRAWN = frozenset({Origin.MODEL, Origin.SURFACE})
#: Sources of what cameras see of a channel.
VISUAL = (
    Heading, Headings, StereoPosition, BlobSignal, StereoSignal, InstanceCount, SurfacePoint,
    NovelHeading, MarkHeading,
)  # fmt: skip
#: Sources of what cameras see of two channels.
RELATIVE = (ConstellationSignal, StereoOffset)


class Resource(NamedTuple):
    """A named, typed signal.

    Attributes:
        name: its name in programs, such as ``right_arm.position``.
        type: what it carries.
        origin: where it arises.
        source: what the signal layer has to read or compute.
        movable: whether it can be an effector, directly or through its Jacobian (Eq 3.17).
    """

    name: str
    type: ResourceType
    origin: Origin
    source: Source
    movable: bool = False

    @property
    def is_drawn(self) -> bool:
        """Whether it is drawn when a controller begins, and stays as it is until that ends."""
        return self.origin in _DRAWN
