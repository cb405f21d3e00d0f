"""Constants of a robot: signs, rates, and settings that have no effect."""

from __future__ import annotations

from functools import reduce
from typing import Any

from cbdsl.checking.robot.pace import check_gain, check_window
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, all_known
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.unsupported_joint import unsupported
from cbdsl.robot.urdf import UrdfModel
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]

_POSITIVE: tuple[Steps, ...] = (
    ("control", "joint_speed"),
    ("control", "lead"),
    ("vision", "regions", "farthest"),
)
_NOT_NEGATIVE: tuple[Steps, ...] = (
    ("contact", "threshold"),
    ("joint_torques", "threshold"),
    ("joint_torques", "filter"),
    ("contact", "noise"),
    ("contact", "bias"),
    ("contact", "drift"),
    ("control", "limit_margin"),
    ("control", "damping"),
    ("control", "singular_value"),
    ("vision", "regions", "ray_gap"),
    ("vision", "regions", "hand_radius"),
)
# Past positions and postures are kept a little longer, s.
_LATEST = 1.0
_RATES: tuple[Steps, ...] = (
    ("control", "rate"),
    ("vision", "rate"),
    ("simulation", "physics_rate"),
)


def check_constants(loaded: Loaded[RobotDocument], diagnostics: Diagnostics) -> None:
    """Check the robot's numbers that can be checked without its model."""
    robot, source = loaded.document, loaded.source
    surfaces = range(len(robot.simulation.surfaces))
    positive = [
        *_POSITIVE,
        *(("simulation", "surfaces", i, "stiffness") for i in surfaces),
        *(("simulation", "efforts", joint) for joint in robot.simulation.efforts),
    ]
    not_negative = [*_NOT_NEGATIVE, *(("simulation", "surfaces", i, "damping") for i in surfaces)]
    check_signs(robot, source, (), positive, not_negative, diagnostics)
    if robot.vision.latency > _LATEST:
        place = source.place("vision", "latency")
        problem = f"a latency of {robot.vision.latency:g} s is too long for control"
        diagnostics.add("CB208", place, problem=f"{problem}; it must be at most {_LATEST:g} s")
    rates = (source.known(reduce(_part, rate, robot), *rate) for rate in _RATES)
    if all_known(rates) is not UNKNOWN:
        _rates(robot, source, diagnostics)
        _tasks(robot, source, diagnostics)


def check_signs(
    document: Any,
    source: SourceMap,
    steps: Steps,
    positive: list[Steps],
    not_negative: list[Steps],
    diagnostics: Diagnostics,
) -> None:
    """Report numbers in the text that have the wrong sign.

    Args:
        document: Part of a document.
        source: Source map of the document.
        steps: Path of the part.
        positive: Paths in the part, of values that have to be above 0.
        not_negative: Paths in the part, of values that have to be 0 or above.
        diagnostics: Diagnostics so far.
    """
    for wanted, paths in (("greater than 0", positive), ("at least 0", not_negative)):
        for path in paths:
            value: Any = reduce(_part, path, document)
            if value is not None and (value < 0 or (value == 0 and paths is positive)):
                place = source.place(*steps, *path)
                diagnostics.add("CB208", place, problem=f"it must be {wanted}")


def _part(value: Any, step: Any) -> Any:
    if value is None:
        return None
    return value[step] if isinstance(value, (dict, tuple)) else getattr(value, step)


# No simulation has more physics steps in a control period.
_MOST_STEPS = 1e6


def _rates(robot: RobotDocument, source: SourceMap, diagnostics: Diagnostics) -> None:
    """Check that physics steps fit into the control period, and images are no faster than ticks."""
    control, physics = robot.control.rate, robot.simulation.physics_rate
    ratio = physics / control
    rate: Steps = ("control", "rate")
    # A tiny control rate such as 1e-308 makes the ratio infinite, which ``round`` refuses.
    whole = round(min(ratio, _MOST_STEPS))
    if whole < 1 or abs(ratio - whole) > 1e-9:
        steps: Steps = ("simulation", "physics_rate")
        would_do = max(1, whole) * control
        problem = (
            f"{physics:g} physics steps per second are not a multiple of {control:g} ticks; write "
            f"a multiple, such as {would_do:g}"
        )
        place = source.place(*(steps if source.holds(*steps) else rate))
        diagnostics.add("CB313", place, problem=problem)
    if robot.cameras and robot.vision.rate > control:
        steps = ("vision", "rate")
        problem = f"{robot.vision.rate:g} images per second are more than {control:g} ticks"
        place = source.place(*(steps if source.holds(*steps) else rate))
        diagnostics.add("CB313", place, problem=problem)


def _tasks(robot: RobotDocument, source: SourceMap, diagnostics: Diagnostics) -> None:
    for name, settings in robot.control.tasks.items():
        steps: Steps = ("control", "tasks", name)
        check_gain(settings.gain, robot, source, steps, diagnostics)
        seen = name == "heading" and bool(robot.cameras)
        check_window(settings.quiescence.window, seen, robot, source, steps, diagnostics)


def check_margins(
    loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics
) -> None:
    """Check that the limit margin leaves a range to each joint."""
    robot, source = loaded.document, loaded.source
    margin = robot.control.limit_margin
    for name, effector in robot.effectors.items():
        for i, joint in enumerate(effector.joints):
            limits = model.joints.get(joint)
            if limits is None or unsupported(limits) is not None:
                continue
            if not limits.lower + margin <= limits.upper - margin:
                details = {"lower": f"{limits.lower:.4g}", "upper": f"{limits.upper:.4g}"}
                place = source.place("effectors", name, "joints", i)
                related = [(source.key("control", "limit_margin"), "the margin")]
                related = related if source.holds("control", "limit_margin") else []
                details |= {"name": joint, "margin": f"{margin:g}"}
                diagnostics.add("CB316", place, related=related, **details)
