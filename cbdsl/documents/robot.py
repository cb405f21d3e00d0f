"""The robot document: what can be sensed and moved, and the constants of this body."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from cbdsl.documents.document import (
    Angle,
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
    Time,
    Tolerance,
    Torque,
    Turn,
    Vector,
)
from cbdsl.documents.driver import Driver
from cbdsl.documents.kind import Kind


class TipSection(Section):
    """The frame of an effector that is moved in Cartesian space."""

    link: LinkName
    """Link of the URDF that carries the frame."""
    offset: Point = (0.0, 0.0, 0.0)
    """Control point in the link's frame."""


class Effector(Section):
    """A synergy: joints that are controlled together (Eq 3.8)."""

    joints: Annotated[tuple[JointName, ...], Field(min_length=1)]
    """Actuated joints of the URDF, in order."""
    tip: TipSection | None = None
    """The frame that gives this effector a position and an orientation."""
    postures: dict[Name, tuple[Coordinate, ...]] = {}
    """Named joint postures: an angle per joint, or a length where it slides."""
    start: Name | None = None
    """Posture at the start of an episode; without it, zero within the limits."""
    count_turns: bool = False
    """Whether whole turns of its joints without limits count, as where cables wind up; without it
    these joints take the short way to a reference."""
    resolution: Distance = 1e-4
    """Step of its joints' encoders: an angle, or a length where they slide; ``0`` without steps."""


class Group(Section):
    """Effectors that are moved together, such as both arms."""

    members: Annotated[tuple[Name, ...], Field(min_length=2)]
    """The effectors, in the order of the group's joints."""


class Coupling(Section):
    """A passive joint that follows an actuated one."""

    follows: JointName
    """The actuated joint."""
    ratio: Number
    """Motion of the passive joint per motion of the actuated one."""
    offset: Coordinate = 0.0
    """Position of the passive joint where the actuated one is at 0."""

    @property
    def recorded(self) -> list[str | float]:
        """The coupling as recordings have it: joint, ratio, and the offset unless it is 0."""
        return [self.follows, self.ratio, *([self.offset] if self.offset else [])]


def _require_direction(vector: Vector) -> Vector:
    if not any(vector):
        raise ValueError("a vector of length 0 has no direction")
    return vector


class LoadCell(Section):
    """A six-axis load cell on a fingertip."""

    link: LinkName
    """Link of the URDF that carries the cell."""
    joint: JointName
    """Actuated joint that flexes this finger, or slides it."""
    normal: Annotated[Vector, AfterValidator(_require_direction)]
    """Direction in the link's frame in which the finger presses."""
    share: Positive = 1.0
    """Share of a force reference that this finger takes, so that opposing fingers balance."""


class Sensor(Section):
    """A sensor of a kind that another package adds."""

    kind: Name
    """Name of the kind."""
    link: LinkName | None = None
    """Link of the URDF that carries it."""
    hand: Name | None = None
    """Effector whose load cells it goes by."""
    options: dict[Name, Number] = {}
    """Numbers that the kind asks for."""


class Correction(Section):
    """Displacement of a camera from its link, as a calibration found it."""

    position: Point = (0.0, 0.0, 0.0)
    """The optical centre, in the link's frame."""
    rotation: Turn = (0.0, 0.0, 0.0)
    """Rotation vector from the link's axes to the camera's: its axis times its angle."""


class Camera(Section):
    """A pinhole camera; its frame looks along +x, with +y to its left and +z up."""

    link: LinkName
    """Link of the URDF at the optical centre."""
    width: PositiveCount
    """Image width, px."""
    height: PositiveCount
    """Image height, px."""
    focal_length: Pixels
    """Focal length at this width, px."""
    correction: Correction | None = None
    """Where it is instead of exactly at the link, as far as the robot knows."""


class Channels(Section):
    """How the images are divided into channels (Eq 3.10)."""

    hue: Count = 10
    """Number of equal hue bins, numbered from 1."""
    saturation: Count = 10
    """Number of equal saturation bins, numbered from 1."""
    intensity: Count = 10
    """Number of equal intensity bins, numbered from 1."""
    motion: bool = True
    """Whether there is a channel for pixels that changed since the image before."""
    least_intensity: NonNegative = 0.16
    """Darker pixels have neither hue nor saturation."""
    least_saturation: NonNegative = 0.3
    """Paler pixels have no hue."""
    aliases: dict[Name, str] = {}
    """Further names of channels, such as ``green: hue_4``."""


class Regions(Section):
    """When a channel's pixels count as a region, and how its position is remembered."""

    least_area: PositiveCount = 12
    """Smaller regions are noise, px."""
    ray_gap: Length = 0.02
    """Largest distance between the two lines of sight at their crossing."""
    farthest: Length = 2.5
    """Farthest position that is believed."""
    instances: Annotated[int, Field(ge=1, le=6)] = 4
    """How many things of one channel are kept apart."""
    least_visible: NonNegative = 0.98
    """Share of the largest apparent size below which a region counts as hidden in part."""
    linger: Time = 0.25
    """How long a heading outlives its region."""
    hold: Time = 0.5
    """How long a position outlives its region when no hand explains the loss."""
    hand_radius: Length = 0.18
    """A hand this near to the line of sight explains that a region is hidden."""
    prediction: Time = 3.0
    """How long a moving region is predicted while hidden."""
    gains: tuple[NonNegative, NonNegative] = (0.5, 0.12)
    """Gains of the alpha-beta filter on positions."""
    least_speed: AnySpeed = 0.008
    """Slower regions are taken to stand still."""


class VisionSection(Section):
    """How images are made and read."""

    rate: Rate = 15.0
    """Images per second."""
    latency: Time = 1 / 15
    """From an exposure until its image can be read."""
    noise: NonNegative = 2.0
    """Standard deviation of a pixel's value, of 255; ideal cameras measure regions as much worse as
    that makes them."""
    renderer: Literal["auto", "opengl", "tiny", "mujoco"] = "auto"
    """``opengl`` needs EGL; ``tiny``, of the backend bullet, runs everywhere; ``mujoco`` is that of
    the backend mujoco, and needs EGL; ``auto`` takes the first that works of the former two."""
    channels: Channels = Channels.model_construct()
    regions: Regions = Regions.model_construct()


class QuiescenceSection(Section):
    """When a controller is at rest: the range of phi over a window, per window (Eq 4.1)."""

    rate: Positive
    """Largest rate of phi at rest, in its unit per second."""
    window: Duration
    """How long phi is watched."""
    within: Positive | None = None
    """Largest residual at rest, as a share of the reference's norm; beyond it, 0 is read."""
    tolerance: Tolerance | None = None
    """Largest residual at rest, in the feedback's unit; beyond it, the predicate is 0."""


class TaskSettings(Section):
    """How a controller whose feedback is of one type behaves unless it says otherwise."""

    gain: Rate
    """kappa: Newton steps per second, 1/s. A spring's Newton step is half its residual."""
    speed: AnySpeed | None = None
    """Largest rate of the task coordinates."""
    acceleration: AnyAcceleration | None = None
    """Largest acceleration of the task coordinates."""
    quiescence: QuiescenceSection


class Control(Section):
    """The control cycle and its guards."""

    rate: Rate
    """Control ticks per second."""
    joint_speed: AngularSpeed = 1.5
    """Largest joint speed that the law asks for."""
    lead: Angle = 0.12
    """Largest distance of a joint's reference from its measured position."""
    limit_margin: Angle = 0.01
    """Joints are kept this far from their limits."""
    damping: Number = 0.01
    """Largest damping of a step near a singularity."""
    singular_value: Number = 0.04
    """Singular value below which damping sets in."""
    tasks: dict[str, TaskSettings]
    """Settings by the type of the feedback."""
    stiffness: Positive = 5.0
    """Fingertip force per joint angle assumed by force -> displacement, N/rad."""
    slide_stiffness: Positive = 1500.0
    """The same of finger joints that slide, N/m."""
    contact_stiffness: Positive = 100.0
    """Force per displacement of the link that feels it assumed by force -> displacement, N/m."""
    contact_torsion: Positive = 1.0
    """Torque per turn of the link that feels it assumed by torque -> displacement, N m/rad."""


class Contact(Section):
    """Threshold of contact on a load cell, and its measurement errors."""

    threshold: Force = 0.1
    """Smaller forces are noise."""
    noise: Force = 0.03
    """Standard deviation of each measured component."""
    bias: Force = 0.2
    """Standard deviation of each component's reading without load, in the cell's own frame."""
    drift: Force = 0.003
    """Standard deviation of how far that has wandered after a second; it grows with the square root
    of the time."""
    filter: Time = 0.02
    """Time constant of the load cells' low-pass filter."""
    zero_tracking: Duration = 5.0
    """Time constant with which a cell that feels nothing follows its drift."""
    self_contact: Length = 0.04
    """Fingertips of two hands that feel something and are no farther apart feel each other."""


class JointTorques(Section):
    """Drives that measure the torques of their joints, which feel contacts anywhere on an arm."""

    threshold: Torque = 10.0
    """Torques, of all joints of an arm together, that motion without contact may cause."""
    filter: Time = 0.05
    """Time constant of the low-pass filter behind them."""


class TipSurface(Section):
    """The material of the links that touch things."""

    links: tuple[LinkName, ...] = ()
    """Links of the URDF; a trailing * matches any ending."""
    friction: NonNegative = 1.0
    """Coefficient of lateral friction."""
    stiffness: Number | None = None
    """Contact stiffness, N/m; rigid without it."""
    damping: Number | None = None
    """Contact damping, N s/m."""
    friction_anchor: bool = False
    """Whether points of contact that stick return to where they first touched. Without it, those of
    soft surfaces creep under a steady load."""


class MujocoSection(Section):
    """Constants of the engine ``mujoco``; the defaults hold things that are grasped."""

    servo_frequency: Rate = 90.0
    """Natural frequency of the joint servos, rad/s: their stiffness per inertia, square root."""
    armature: NonNegative = 1.0
    """Inertia of the joints' drives, as a share of the moved inertia; 1 is matched gearing."""
    contact_time: Duration = 0.01
    """Time constant with which contacts push things apart."""
    spinning_friction: Lever = 0.005
    """Torque about the normal of a contact that friction bears, per force of the contact."""
    friction_stiffness: Positive = 1.0
    """How much stiffer contacts are along the surfaces than across them."""
    noslip_iterations: Count = 5
    """Iterations that end all creeping, so that things stay in the hand; without any, contacts
    creep under load."""


class Simulation(Section):
    """Constants that only a simulated body needs."""

    physics_rate: Rate = 240.0
    """Physics steps per second."""
    solver_iterations: PositiveCount = 20
    """Iterations of the contact solver per physics step."""
    position_gain: NonNegative = 0.3
    """Gain of the simulated servos on a joint's position error."""
    velocity_gain: NonNegative = 1.0
    """Gain of the simulated servos on a joint's velocity error."""
    efforts: dict[str, Torque] = {}
    """Joint torques that replace the URDF's."""
    surfaces: tuple[TipSurface, ...] = ()
    """Materials of links; the others have those of the URDF."""
    no_contact: tuple[tuple[LinkName, ...], ...] = ()
    """Groups of links whose mutual contacts are ignored; a trailing * matches any ending."""
    mujoco: MujocoSection = MujocoSection.model_construct()


class RobotDocument(Document):
    """Everything that the framework knows about one robot."""

    kind: Literal["robot"]
    """Says that this document is a robot."""
    model: str
    """URDF file, relative to this document."""
    base: LinkName
    """Link whose frame is the world frame."""
    effectors: dict[Name, Effector]
    """Groups of joints that move, by name."""
    groups: dict[Name, Group] = {}
    """Effectors that programs can name together."""
    couplings: dict[str, Coupling] = {}
    """Passive joints, by name."""
    load_cells: dict[Name, dict[Name, LoadCell]] = {}
    """Load cells by hand (an effector) and finger."""
    cameras: dict[Name, Camera] = {}
    """Cameras, by name; two of them triangulate."""
    calibration: Name | None = None
    """Calibration that corrects where they are."""
    sensors: dict[Name, Sensor] = {}
    """Sensors of kinds that other packages add, by name."""
    vision: VisionSection = VisionSection.model_construct()
    contact: Contact = Contact.model_construct()
    joint_torques: JointTorques | None = None
    """Without it no joint's torque is measured."""
    control: Control
    drivers: dict[Name, Driver] = {}
    """Connections to the real robot, by name; a simulated one needs none."""
    simulation: Simulation = Simulation.model_construct()

    def members(self, effector: str) -> tuple[str, ...]:
        """The effectors of a group, or the one effector that is named itself."""
        group = self.groups.get(effector)
        return (effector,) if group is None else group.members

    def joints(self, effector: str) -> tuple[str, ...]:
        """The actuated joints of an effector, or of a group's members in turn."""
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
