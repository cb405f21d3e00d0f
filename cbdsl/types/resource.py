"""Resources: named, typed signals of one robot, with their sources."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.types.resource_type import ResourceType

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from cbdsl.numeric.affordance_model import AffordanceModel

#: Prefix of the names of probabilities that a catalog predicts.
AFFORDS = "affords."
#: Name of the mean of all cameras, which has no image of its own.
CYCLOPEAN = "cyclopean"
#: Prefix of the names of likenesses to the pairs of a meta-catalog.
LIKENESS_OF = "likeness."


class Origin(Enum):
    """Origin of a signal (Eq 3.16); only ``ENVIRONMENT`` can be rewarded (Eq 4.3)."""

    ENVIRONMENT = "environment"
    PROPRIOCEPTION = "proprioception"
    KINEMATICS = "kinematics"
    TRIANGULATION = "triangulation"
    MODEL = "internal model"
    SURFACE = "visible surface"
    CONSTANT = "constant"


class EffectorConfiguration(NamedTuple):
    """Joint positions of an effector or a group."""

    effector: str


class Tip(NamedTuple):
    """``position``, ``orientation`` or ``pose`` of an effector's tip, in the world frame.

    For a group: the positions of all tips.
    """

    effector: str
    part: str


class Centroid(NamedTuple):
    """Mean position of a group's tips, in the world frame (Section 3.3.3.2)."""

    group: str


class Separation(NamedTuple):
    """Position of the second tip of a group of two relative to the first, in world axes."""

    group: str


class FingerLoad(NamedTuple):
    """``force``, ``torque`` or ``wrench`` that a finger exerts, in the world frame."""

    hand: str
    finger: str
    part: str


class NetLoad(NamedTuple):
    """Sum over a hand's fingers of their ``force``, ``torque`` or ``wrench``."""

    hand: str
    part: str


class NetForces(NamedTuple):
    """Net force of each hand of a group, in turn (Eq 3.34), or of one hand."""

    group: str


class FingerForces(NamedTuple):
    """Forces of all fingers of a hand, in the order of the robot file."""

    hand: str


SELECTIONS = ("nearest", "largest", "leftmost", "rightmost", "other")
"""Instances of a channel that are selected among those remembered, at any moment anew.

Nearest to the cameras, with the largest radius, farthest to the left or right as the cameras' place
has it; or the nearest to the one attended to, apart from that. Others are numbered from 1 in the
order of discovery, and "" is the one attended to.
"""


class Heading(NamedTuple):
    """Heading of an object of a channel in a camera; ``cyclopean`` is the mean over the cameras."""

    camera: str
    channel: str
    instance: str = ""


class Headings(NamedTuple):
    """Headings of an object of a channel, camera by camera (Eq 3.14)."""

    channel: str
    instance: str = ""


class StereoPosition(NamedTuple):
    """Triangulated position of an object of a channel, in the world frame (Eq 3.14)."""

    channel: str
    instance: str = ""


class BlobSignal(NamedTuple):
    """Property of the blob of a channel in a camera's image (Fig 7.15).

    Attributes:
        camera: Name of the camera.
        channel: Channel of the region.
        part: ``velocity``, ``extent`` or ``orientation``.
        instance: Instance of the channel.
    """

    camera: str
    channel: str
    part: str
    instance: str = ""


class StereoSignal(NamedTuple):
    """``velocity`` or ``volume`` of an object of a channel in both cameras (Section 5.3)."""

    channel: str
    part: str
    instance: str = ""


class ObjectDistance(NamedTuple):
    """Distance of an object of a channel from the base of an effector: its first joint.

    For a group: the least distance from the bases of its members.
    """

    channel: str
    effector: str
    instance: str = ""


class ConstellationSignal(NamedTuple):
    """Constellation of two channels' blobs in a camera's image (Fig 7.15).

    Attributes:
        camera: Name of the camera.
        channel: Channel of the compared blob.
        other: Channel of the blob with which it is compared.
    """

    camera: str
    channel: str
    other: str


class StereoOffset(NamedTuple):
    """Position of an object of a channel relative to an object of another channel."""

    channel: str
    other: str


class SolidSignal(NamedTuple):
    """Size of an object of a channel that stands on the level of another object.

    Attributes:
        channel: Channel of the object.
        other: Channel of the object whose level it stands on.
        part: ``length``, ``width``, ``height``, ``bulk``, ``top``, ``placed``, ``above`` or
            ``beside``.
        effector: Effector whose tip is beside the object; empty otherwise.
    """

    channel: str
    other: str
    part: str
    effector: str = ""

    @property
    def pair(self) -> tuple[str, str]:
        """Channels of the object and of its level."""
        return self.channel, self.other


class LinkDistance(NamedTuple):
    """Least distance between the links that an effector or a group moves and other bodies.

    Attributes:
        effector: Name of the effector or group.
        other: Another one, or a place to keep out of, a fixture or a seen object; empty for all
            other links and places to keep out of.
        links: Links that move with either.
        features: Position of the seen object; empty for other bodies.
        is_fixture: True if the other one is a fixture of the stage.
    """

    effector: str
    other: str
    links: tuple[str, ...]
    features: tuple[Resource, ...] = ()
    is_fixture: bool = False

    @property
    def name(self) -> str:
        """Name of the distance."""
        return f"{self.effector}.{f'from.{self.other}' if self.other else 'clearance'}"


class Opening(NamedTuple):
    """Distance between the opposing fingertips of a hand."""

    hand: str


class GraspCentre(NamedTuple):
    """Point between the opposing fingertips of a hand, in the world frame."""

    hand: str


class InstanceCount(NamedTuple):
    """Number of remembered objects of a channel."""

    channel: str


class SurfacePoint(NamedTuple):
    """Draw from the visible points of a surface that fills the images of a channel."""

    channel: str


class SensorSignal(NamedTuple):
    """Signal of a sensor whose kind another package adds, as declared by a robot document.

    Attributes:
        sensor: Name of the sensor in the document.
        kind: Name of the kind.
        part: Name of the signal among the sensor's signals.
        links: Links of the model that carry the sensor.
    """

    sensor: str
    kind: str
    part: str
    links: tuple[str, ...]


class ModelSignal(NamedTuple):
    """Signal that a model of another package computes from other signals.

    Attributes:
        model: Name of the model's document.
        kind: Kind of that document.
        effector: Effector, group or hand that the signal belongs to.
        reader: ``module:function`` of (signal, signals) that returns the reader of the signal.
        features: Resources from which it is computed.
        data: Constants of the package; hashable, and equal for equal behaviour.
    """

    model: str
    kind: str
    effector: str
    reader: str
    features: tuple[Resource, ...]
    data: Hashable


class Posture(NamedTuple):
    """Named joint posture of the robot file."""

    effector: str
    posture: str


class Turned(NamedTuple):
    """Posture in which an effector has turned a held object before the cameras.

    It follows from the model of the robot.
    """

    effector: str


class UniformSample(NamedTuple):
    """Draw from the uniform distribution between an effector's joint limits."""

    effector: str


class GaussianSample(NamedTuple):
    """Draw from normal distributions of an effector's joints, rad.

    A share of ``uniform`` of the draws is uniform between the joint limits instead.
    """

    effector: str
    mean: tuple[float, ...]
    deviation: tuple[float, ...]
    uniform: float = 0.0

    @property
    def centres(self) -> tuple[tuple[float, ...], ...]:
        """Centre of the only kernel, rad."""
        return (self.mean,)

    @property
    def spread(self) -> tuple[float, ...]:
        """Standard deviations, rad."""
        return self.deviation


class KernelSample(NamedTuple):
    """Draw from Gaussian kernels around configurations of an effector, rad.

    A share of ``uniform`` of the draws is uniform between the joint limits instead.
    """

    effector: str
    samples: tuple[tuple[float, ...], ...]
    bandwidth: tuple[float, ...]
    uniform: float = 0.0

    @property
    def centres(self) -> tuple[tuple[float, ...], ...]:
        """Centres of the kernels, rad."""
        return self.samples

    @property
    def spread(self) -> tuple[float, ...]:
        """Standard deviations of each kernel, rad."""
        return self.bandwidth


class NovelHeading(NamedTuple):
    """Heading of a region of a channel that its background model does not expect.

    Attributes:
        channel: Name of the channel.
        effector: Effector that moves the cameras.
        expected: Density of the effector configurations in which the channel was tracked.
    """

    channel: str
    effector: str
    expected: GaussianSample | KernelSample


class MarkHeading(NamedTuple):
    """Heading of a mark on an object whose hue differs from the object's hue.

    Attributes:
        channel: Channel of the object.
        hues: Possible channels of the mark.
    """

    channel: str
    hues: tuple[str, ...]


class AffordanceProbability(NamedTuple):
    """Probability that an action is rewarded, Pr(reward | f, a), from a catalog (6.1).

    Attributes:
        catalog: Name of the catalog.
        action: Name of one of its actions.
        model: Affordance model of the action.
        features: Resources of its features f, in the order of the model's components.
    """

    catalog: str
    action: str
    model: AffordanceModel
    features: tuple[Resource, ...]


class PairLikeness(NamedTuple):
    """Likeness of two objects to a known pair (Section 7.3.1).

    Attributes:
        catalog: Name of the meta-catalog.
        pair: Name of one of its pairs.
        fitted: Function that returns the model; repeated calls return the same object.
        features: Resources of these features, in the order of the model's components.
    """

    catalog: str
    pair: str
    fitted: Callable[[], AffordanceModel]
    features: tuple[Resource, ...]

    @property
    def model(self) -> AffordanceModel:
        """Model of the features of the pair when it stayed."""
        return self.fitted()


Source = (
    EffectorConfiguration | Tip | Centroid | Separation | FingerLoad | NetLoad | NetForces |
    FingerForces | Heading | Headings | StereoPosition | BlobSignal | StereoSignal |
    ObjectDistance | ConstellationSignal | StereoOffset | SolidSignal | LinkDistance | Opening |
    GraspCentre | InstanceCount | NovelHeading | MarkHeading | AffordanceProbability |
    PairLikeness | SurfacePoint | SensorSignal | ModelSignal | Posture | Turned | UniformSample
    | GaussianSample | KernelSample
)  # fmt: skip


# These values are random. A new one in each tick would be a reference that no controller can reach.
_DRAWN = frozenset({Origin.MODEL, Origin.SURFACE})


class Resource(NamedTuple):
    """Named, typed signal.

    Attributes:
        name: Name in programs, such as ``right_arm.position``.
        type: Type of its quantity.
        origin: Origin of the signal.
        source: Source that the signal layer reads or computes.
        movable: True if it can be an effector, directly or through its Jacobian (Eq 3.17).
    """

    name: str
    type: ResourceType
    origin: Origin
    source: Source
    movable: bool = False

    @property
    def is_drawn(self) -> bool:
        """True if the value is drawn when a controller begins, and is constant until its end."""
        return self.origin in _DRAWN
