"""Robot document: sensors, effectors and constants of a robot."""

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from cbdsl.documents.document import (
    Angle,
    AngleSpan,
    AngularSpeed,
    AnyAcceleration,
    AnySpeed,
    Coordinate,
    Count,
    Distance,
    Document,
    Duration,
    Force,
    JointName,
    Length,
    Lever,
    LinkName,
    Name,
    NonNegative,
    Number,
    Pixels,
    Point,
    Positive,
    PositiveCount,
    Rate,
    Section,
    Size,
    Time,
    Tolerance,
    Torque,
    Turn,
    Vector,
)
from cbdsl.documents.driver import Driver
from cbdsl.documents.kind import Kind
from cbdsl.documents.simulation_section import Simulation


class TipSection(Section):
    """Frame of an effector that moves in Cartesian space."""

    link: LinkName
    """Link of the URDF with the frame."""
    offset: Point = (0.0, 0.0, 0.0)
    """Control point in the link's frame."""


class Effector(Section):
    """Synergy: joints that are controlled together (Eq 3.8)."""

    joints: Annotated[tuple[JointName, ...], Field(min_length=1)]
    """Actuated joints of the URDF, in order."""
    tip: TipSection | None = None
    """Frame of the position and orientation of this effector."""
    postures: dict[Name, tuple[Coordinate, ...]] = {}
    """Named joint postures: an angle per joint, or a length if it slides."""
    values: dict[Name, str] = {}
    """Texts for programs over roles, by name: `{grip: 8 N}` is `$hand.grip` for a role `hand`."""
    start: Name | None = None
    """Posture at the start of an episode; zero within the limits if omitted."""
    count_turns: bool = False
    """True if whole turns of its joints without limits count, as when cables wind up; otherwise
    these joints take the short way to a reference."""
    resolution: Distance = 1e-4
    """Step of its joints' encoders: an angle, or a length if they slide; ``0`` for no steps."""


class Group(Section):
    """Effectors that move together, such as both arms."""

    members: Annotated[tuple[Name, ...], Field(min_length=2)]
    """Effectors, in the order of the group's joints."""


class Coupling(Section):
    """Passive joint that follows an actuated one."""

    follows: JointName
    """Actuated joint."""
    ratio: Number
    """Motion of the passive joint per motion of the actuated one."""
    offset: Coordinate = 0.0
    """Position of the passive joint while the actuated one is at 0."""

    @property
    def recorded(self) -> list[str | float]:
        """Coupling in recordings: joint, ratio, and the offset unless it is 0."""
        return [self.follows, self.ratio, *([self.offset] if self.offset else [])]


def _require_direction(vector: Vector) -> Vector:
    if not any(vector):
        raise ValueError("a vector of length 0 has no direction")
    return vector


class LoadCell(Section):
    """Six-axis load cell on a fingertip."""

    link: LinkName
    """Link of the URDF with the cell."""
    joint: JointName
    """Actuated joint that flexes or slides this finger; fingers that share one feel their mean."""
    normal: Annotated[Vector, AfterValidator(_require_direction)]
    """Direction in the link's frame in which the finger presses."""
    share: Positive = 1.0
    """Share of a force reference for this finger, so that opposing fingers balance."""
    radius: Lever = 0.0
    """Radius of a round fingertip about the link's origin; without it, contacts are at the pad."""
    pad: Point = (0.0, 0.0, 0.0)
    """Middle of the surface that presses, in the link's frame."""

    @model_validator(mode="after")
    def _presses_with_one_surface(self) -> Self:
        if self.radius and any(self.pad):
            raise ValueError("a round fingertip has no `pad`; give the `radius` or the pad alone")
        return self


class Sensor(Section):
    """Sensor of a kind from another package."""

    kind: Name
    """Name of the kind."""
    link: LinkName | None = None
    """Link of the URDF with the sensor."""
    hand: Name | None = None
    """Effector with the load cells that the sensor uses."""
    options: dict[Name, Number] = {}
    """Numbers for the kind of sensor."""


class Correction(Section):
    """Displacement of a camera from its link, as estimated by a calibration."""

    position: Point = (0.0, 0.0, 0.0)
    """Optical centre, in the link's frame."""
    rotation: Turn = (0.0, 0.0, 0.0)
    """Rotation vector from the link's axes to the camera's: axis times angle."""


# A point (x, y, z) in the camera's frame is seen at column w / 2 - f y / x and row h / 2 - f z / x.
# The image has w columns and h rows, and the focal length f is in px. Pixels are square, the
# optical axis meets the middle of the image, and there is no distortion.
class Camera(Section):
    """Pinhole camera; its frame has +x forwards, +y to the left and +z up."""

    link: LinkName
    """Link of the URDF at the optical centre."""
    width: PositiveCount
    """Image width, px."""
    height: PositiveCount
    """Image height, px."""
    focal_length: Pixels
    """Focal length at this width, px."""
    correction: Correction | None = None
    """Estimated displacement from the link; none if omitted."""


class ColorRange(Section):
    """Colours that go by one name: ranges of hue, saturation and value."""

    hue: AngleSpan
    """First and last hue: 0 is red, 120 deg green and 240 deg blue; the range may pass 0."""
    saturation: tuple[NonNegative, NonNegative] = (0.0, 1.0)
    """Smallest and largest saturation, from 0 (grey) to 1."""
    value: tuple[NonNegative, NonNegative] = (0.0, 1.0)
    """Smallest and largest value, from 0 (black) to 1."""


class Channels(Section):
    """Division of the images into channels (Eq 3.10)."""

    hue: Count = 10
    """Number of equal hue bins, numbered from 1."""
    saturation: Count = 10
    """Number of equal saturation bins, numbered from 1."""
    intensity: Count = 10
    """Number of equal intensity bins, numbered from 1."""
    motion: bool = True
    """True to have a channel of the pixels that changed since the last image."""
    least_intensity: NonNegative = 0.16
    """Intensity below which pixels have neither hue nor saturation."""
    least_saturation: NonNegative = 0.3
    """Saturation below which pixels have no hue."""
    colors: dict[Name, Annotated[tuple[ColorRange, ...], Field(min_length=1)]] = {}
    """Named colours besides ``red``, ``yellow``, ``green`` and ``blue``, or in place of them; a
    colour is in any of its ranges."""
    aliases: dict[Name, str] = {}
    """Further names of channels, such as ``grey: sat_1``."""


# Positions of moving regions are estimated by an alpha-beta filter with constant velocity. It
# predicts x' = x + v T over the period T between images. The measured position z corrects x by
# alpha (z - x') and v by beta (z - x') / T. ``gains`` are the settled alpha and beta; the first
# images of a region have larger ones.
class Regions(Section):
    """Conditions on regions of a channel, and memory of their positions."""

    least_area: PositiveCount = 12
    """Minimum area of a region, px; smaller ones are noise."""
    ray_gap: Length = 0.02
    """Maximum distance between the two lines of sight at their crossing."""
    farthest: Length = 2.5
    """Maximum distance of a position."""
    instances: Annotated[int, Field(ge=1, le=6)] = 4
    """Maximum number of objects of one channel."""
    least_visible: NonNegative = 0.98
    """Share of the largest apparent size below which a region counts as partly occluded."""
    linger: Time = 0.25
    """Time for which a heading is kept after its region disappears."""
    hold: Time = 0.5
    """Time for which a position is kept after its region disappears, if no hand explains it."""
    hand_radius: Length = 0.18
    """Maximum distance of a hand from the line of sight to explain an occluded region."""
    prediction: Time = 3.0
    """Time for which a moving region is predicted while occluded."""
    gains: tuple[NonNegative, NonNegative] = (0.5, 0.12)
    """Gains of the alpha-beta filter on positions."""
    least_speed: AnySpeed = 0.008
    """Minimum speed of a moving region; slower ones count as stationary."""


class VisionSection(Section):
    """Generation and processing of images."""

    rate: Rate = 15.0
    """Images per second."""
    latency: Time = 1 / 15
    """Time between the exposure of an image and its availability."""
    noise: NonNegative = 2.0
    """Standard deviation of a pixel's value, of 255; ideal cameras add the equivalent error to
    regions."""
    renderer: Literal["auto", "opengl", "tiny", "mujoco"] = "auto"
    """``opengl`` needs EGL; ``tiny``, of the backend bullet, runs everywhere; ``mujoco``, of the
    backend mujoco, needs EGL; ``auto`` takes the first of ``opengl`` and ``tiny`` that works."""
    channels: Channels = Channels.model_construct()
    regions: Regions = Regions.model_construct()
    stereo: tuple[Name, Name] | None = None
    """The two cameras that triangulate, for robots with more cameras; the others give headings of
    their own."""


# Eq 4.1 calls a controller quiescent while |d phi / dt| is at most epsilon. A derivative of
# sampled, noisy values is unreliable, so that the range of phi over a window replaces it.
class QuiescenceSection(Section):
    """Criterion of a controller at rest: range of phi over a window, per window (Eq 4.1)."""

    rate: Positive
    """Maximum rate of phi at rest, in its unit per second."""
    window: Duration
    """Length of the window."""
    within: Positive | None = None
    """Maximum residual at rest, as a share of the reference's norm; beyond it, the predicate is
    0."""
    tolerance: Tolerance | None = None
    """Maximum residual at rest, in the feedback's unit; beyond it, the predicate is 0."""


class TaskSettings(Section):
    """Default settings of controllers with feedback of one type."""

    gain: Rate
    """kappa: Newton steps per second, 1/s. A spring's Newton step is half its residual."""
    speed: AnySpeed | None = None
    """Maximum rate of the task coordinates."""
    acceleration: AnyAcceleration | None = None
    """Maximum acceleration of the task coordinates."""
    arrival: Tolerance | None = None
    """Maximum residual at which a controller at rest has arrived; if omitted, the bound of its
    quiescence or 2 cm, 5 deg, 5 mm of sliding joints; forces and other types have no default."""
    quiescence: QuiescenceSection


class Control(Section):
    """Control cycle and its guards."""

    rate: Rate
    """Control ticks per second."""
    joint_speed: AngularSpeed = 1.5
    """Maximum speed of the joints' references; lagging drives catch up at the model's limit."""
    lead: Angle = 0.12
    """Maximum distance of a joint's reference from its measured position."""
    limit_margin: Angle = 0.01
    """Distance of joints from their limits."""
    damping: Number = 0.01
    """Maximum damping of a step near a singularity."""
    singular_value: Number = 0.04
    """Singular value below which steps are damped."""
    tasks: dict[str, TaskSettings]
    """Settings by the type of the feedback."""
    stiffness: Positive = 5.0
    """Assumed fingertip force per joint angle of the cast force -> displacement, N/rad."""
    slide_stiffness: Positive = 1500.0
    """The same for finger joints that slide, N/m."""
    contact_stiffness: Positive = 100.0
    """Assumed force per displacement of the measuring link of the cast force -> displacement,
    N/m."""
    contact_torsion: Positive = 1.0
    """Assumed torque per turn of the measuring link of the cast torque -> displacement, N m/rad."""


class Contact(Section):
    """Contact threshold of load cells, and their measurement errors."""

    threshold: Force = 0.1
    """Force below which a measurement is noise."""
    noise: Force = 0.03
    """Standard deviation of each measured component."""
    bias: Force = 0.2
    """Standard deviation of each component's reading without load, in the cell's frame."""
    drift: Force = 0.003
    """Standard deviation of the change of the bias after a second; it grows with the square root of
    time."""
    filter: Time = 0.02
    """Time constant of the load cells' low-pass filter."""
    zero_tracking: Duration = 5.0
    """Time constant with which a cell without contact follows its drift."""
    self_contact: Length = 0.04
    """Maximum distance between loaded fingertips of two hands that counts as mutual contact."""


class JointTorques(Section):
    """Drives that measure joint torques, and thus contacts anywhere on an arm."""

    threshold: Torque = 10.0
    """Torque over all joints of an arm that motion without contact may cause."""
    filter: Time = 0.05
    """Time constant of the low-pass filter of the torques."""


class HullSection(Section):
    """Hull of points, grown by a radius: a ball around one point, a capsule around two."""

    points: Annotated[tuple[Point, ...], Field(min_length=1)]
    """Points in the frame of the link, or of the world."""
    radius: Lever = 0.0
    """Distance of the surface from the hull."""


class ClearanceSection(Section):
    """Distances between links, and from places to keep out of."""

    distance: Size | None = None
    """Minimum distance in every program; only that of programs if omitted."""
    ignore: tuple[tuple[LinkName, ...], ...] = ()
    """Groups of links that may touch each other; a trailing * matches any ending."""
    shapes: dict[LinkName, tuple[HullSection, ...]] = {}
    """Shapes of links that replace their collision geometry; an empty list leaves a link out."""
    keep_out: dict[Name, HullSection] = {}
    """Places in the world frame from which links keep the distance, too."""


class RobotDocument(Document):
    """Robot: model, effectors, sensors and settings."""

    kind: Literal["robot"]
    """Kind of this document: a robot."""
    model: str
    """URDF file, relative to this document."""
    base: LinkName
    """Link with the world frame."""
    effectors: dict[Name, Effector]
    """Groups of joints that move, by name."""
    groups: dict[Name, Group] = {}
    """Effectors that programs can name together."""
    roles: dict[Name, Name] = {}
    """Effectors that programs for any robot take first, by their roles."""
    couplings: dict[str, Coupling] = {}
    """Passive joints, by name."""
    load_cells: dict[Name, dict[Name, LoadCell]] = {}
    """Load cells by hand (an effector) and finger."""
    cameras: dict[Name, Camera] = {}
    """Cameras, by name; two triangulate, and of more those of ``vision: stereo``."""
    calibration: Name | None = None
    """Calibration that corrects the places of the cameras."""
    sensors: dict[Name, Sensor] = {}
    """Sensors of kinds from other packages, by name."""
    vision: VisionSection = VisionSection.model_construct()
    contact: Contact = Contact.model_construct()
    joint_torques: JointTorques | None = None
    """Measurement of joint torques; none if omitted."""
    control: Control
    clearance: ClearanceSection = ClearanceSection.model_construct()
    drivers: dict[Name, Driver] = {}
    """Connections to the real robot, by name; none for a simulated one."""
    simulation: Simulation = Simulation.model_construct()

    @property
    def start_postures(self) -> dict[str, tuple[float, ...]]:
        """Posture of each effector that has one at the start of an episode, rad or m."""
        effectors = self.effectors.items()
        return {name: each.postures[each.start] for name, each in effectors if each.start}

    @property
    def main_cameras(self) -> Mapping[str, Camera]:
        """Cameras of signals that name no camera: the stereo pair, or all without a pair."""
        names = [name for name in self.vision.stereo or () if name in self.cameras]
        return {name: self.cameras[name] for name in names} or self.cameras

    @property
    def has_stereo(self) -> bool:
        """Whether two cameras triangulate."""
        return self.vision.stereo is not None or len(self.cameras) == 2

    def members(self, effector: str) -> tuple[str, ...]:
        """Return the effectors of a group, or the named effector itself.

        A name of both, which is an error of its own, is that of the effector.
        """
        is_group = effector in self.groups and effector not in self.effectors
        return self.groups[effector].members if is_group else (effector,)

    @property
    def all_effectors(self) -> tuple[str, ...]:
        """Names of the effectors and groups."""
        return (*self.effectors, *self.groups)

    def joints(self, effector: str) -> tuple[str, ...]:
        """Return the actuated joints of an effector, or of all members of a group in order."""
        return tuple(j for name in self.members(effector) for j in self.effectors[name].joints)


ROBOT = Kind(
    RobotDocument,
    folder="robots",
    checker="cbdsl.checking.document:check_robot",
    unknown="CB601",
    references={"calibration": "calibration"},
    stand_ins={
        "model": "unknown",
        "base": "unknown",
        "effectors": {},
        "control": {"rate": 1, "tasks": {}},
    },
)
