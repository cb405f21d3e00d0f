"""Section of a robot document with the constants of its simulation."""

from cbdsl.documents.document import (
    Count,
    Duration,
    Lever,
    LinkName,
    NonNegative,
    Number,
    Positive,
    PositiveCount,
    Rate,
    Section,
    Torque,
)


class TipSurface(Section):
    """Material of the links that touch objects."""

    links: tuple[LinkName, ...] = ()
    """Links of the URDF; a trailing * matches any ending."""
    friction: NonNegative = 1.0
    """Coefficient of lateral friction."""
    stiffness: Number | None = None
    """Contact stiffness, N/m; rigid if omitted."""
    damping: Number | None = None
    """Contact damping, N s/m."""
    friction_anchor: bool = False
    """True if sticking contacts return to their first places; otherwise soft surfaces creep under
    a steady load."""


class MujocoSection(Section):
    """Constants of the engine ``mujoco``; the defaults hold grasped objects."""

    servo_frequency: Rate = 90.0
    """Natural frequency of the joint servos, rad/s: square root of stiffness per inertia."""
    armature: NonNegative = 1.0
    """Inertia of the joints' drives, as a share of the moved inertia; 1 for matched gearing."""
    contact_time: Duration = 0.01
    """Time constant of the separation of penetrating objects."""
    spinning_friction: Lever = 0.005
    """Maximum frictional torque about the normal of a contact, per force of the contact."""
    friction_stiffness: Positive = 1.0
    """Ratio of the stiffness of contacts along the surfaces to that across them."""
    noslip_iterations: Count = 5
    """Iterations that end creeping, so that objects stay in the hand; with 0, contacts creep under
    load."""


class Simulation(Section):
    """Constants of simulated robots."""

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
    """Materials of links; the last one that names a link counts, and others have the engine's."""
    no_contact: tuple[tuple[LinkName, ...], ...] = ()
    """Groups of links without contacts among each other; a trailing * matches any ending."""
    mujoco: MujocoSection = MujocoSection.model_construct()
