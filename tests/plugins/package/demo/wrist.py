"""Force-torque sensor at a wrist, which carries a hand with load cells."""

from collections.abc import Callable

import numpy as np

from cbdsl.extend.source import FORCE, TORQUE, Reading, SensorSignal, Signals, SourceKind


def reader(signal: SensorSignal, signals: Signals) -> Callable[[], Reading | None]:
    """Return a reader of the sum over the hand's load cells, with the levers from the wrist."""
    robot, (wrist,) = signals.robot, signal.links
    hand = robot.sensors[signal.sensor].hand
    first, last = signals.touch.span(hand)
    links = [cell.link for cell in robot.load_cells[hand].values()]

    def read() -> Reading | None:
        if not signals.touch.touching(hand):
            return None
        kinematics, loads = signals.kinematics, signals.touch.loads[first:last]
        origin, jacobian = kinematics.point(wrist, (0.0, 0.0, 0.0))
        if signal.part == "force":
            value = loads[:, :3].sum(axis=0)
            return Reading(value, robot.control.contact_stiffness * jacobian[:3], signals.clock[0])
        levers = [kinematics.frame(link).position - origin for link in links]
        value = loads[:, 3:].sum(axis=0) + np.cross(levers, loads[:, :3]).sum(axis=0)
        return Reading(value, robot.control.contact_torsion * jacobian[3:], signals.clock[0])

    return read


WRIST = SourceKind(
    "wrist_force_torque",
    "force and torque at a wrist",
    {"force": FORCE, "torque": TORQUE},
    "demo.wrist:reader",
    needs=("link", "hand"),
)
