"""Checks of a robot's model: passive joints, rests, impossible bodies, and postures to hold."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from cbdsl.diagnostics.counting import some
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import Coupling, RobotDocument
from cbdsl.robot.plausibility import flat_shapes, odd_inertias, odd_numbers
from cbdsl.robot.urdf import Mimic, UrdfError, UrdfJoint, UrdfModel
from cbdsl.robot.weight import overloads
from cbdsl.yaml_text.loaded import Loaded


def check_mimics(loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics) -> None:
    """Warn of joints whose mimic element in the model disagrees with the document's coupling."""
    robot, source = loaded.document, loaded.source
    actuated = {joint for effector in robot.effectors.values() for joint in effector.joints}
    for joint in model.joints.values():
        mimic, coupling = joint.mimic, robot.couplings.get(joint.name)
        if mimic is None or joint.name in actuated or _agree(mimic, coupling):
            continue
        # Some models freeze a gripper by this type alone; a fixed joint cannot follow.
        if coupling is None and joint.fixed:
            continue
        # A joint that follows an undriven one rests with it, and needs no coupling.
        if coupling is None and mimic.joint not in actuated:
            continue
        here = "has no coupling" if coupling is None else f"its coupling says {_text(coupling)}"
        place = source.place("model") if coupling is None else source.key("couplings", joint.name)
        details = {"joint": joint.name, "declared": _mimicry(mimic), "here": here}
        diagnostics.add("CB745", place, model=model.path.name, **details)


def _agree(mimic: Mimic, coupling: Coupling | None) -> bool:
    return (
        coupling is not None
        and coupling.follows == mimic.joint
        and math.isclose(coupling.ratio, mimic.ratio, rel_tol=1e-3, abs_tol=1e-6)
        and math.isclose(coupling.offset, mimic.offset, rel_tol=1e-3, abs_tol=1e-4)
    )


def _mimicry(mimic: Mimic) -> str:
    return f"'{mimic.joint}' at ratio {mimic.ratio:g}{_shift(mimic.offset)}"


def _text(coupling: Coupling) -> str:
    return f"'{coupling.follows}' at ratio {coupling.ratio:g}{_shift(coupling.offset)}"


def _shift(offset: float) -> str:
    return f" and offset {offset:g}" if offset else ""


def note_rests(loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics) -> None:
    """Note undriven joints whose rest position is not 0."""
    robot = loaded.document
    driven = {joint for effector in robot.effectors.values() for joint in effector.joints}
    driven.update(robot.couplings)
    resting = [
        f"{name} at {_position(model.joints[name], position)}"
        for name, position in model.rests.items()
        if position and name not in driven
    ]
    if resting:
        place = loaded.source.place("model")
        diagnostics.add("CB744", place, model=model.path.name, joints=some(resting))


def _position(joint: UrdfJoint, position: float) -> str:
    return f"{position:g} {joint.unit}"


def check_bodies(loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics) -> None:
    """Warn of links with impossible moments of inertia or shapes, and of implausible numbers."""
    place = loaded.source.place("model")
    try:
        inertias, flat = [*odd_inertias(model)], [*flat_shapes(model)]
        odd = [*odd_numbers(model)]
    except UrdfError as error:
        diagnostics.add("CB301", place, names=[], given=loaded.document.model, problem=str(error))
        return
    for code, links in (("CB746", inertias), ("CB747", flat)):
        if links:
            diagnostics.add(code, place, model=model.path.name, links=some([*_lines(links)]))
    if odd:
        diagnostics.add("CB748", place, model=model.path.name, parts=some([*_lines(odd)]))


def _lines(links: Sequence[tuple[str, str]]) -> Iterator[str]:
    for name, reason in links:
        yield f"'{name}' {reason}"


def check_weights(
    loaded: Loaded[RobotDocument], model: UrdfModel, diagnostics: Diagnostics
) -> None:
    """Warn of postures that the efforts of the joints cannot hold, with the others at the start."""
    robot = loaded.document
    at_start = {
        joint: position
        for name, posture in robot.start_postures.items()
        for joint, position in zip(robot.effectors[name].joints, posture, strict=True)
    }
    for name, effector in robot.effectors.items():
        efforts = {
            joint: min(model.joints[joint].effort, robot.simulation.efforts.get(joint, math.inf))
            for joint in effector.joints
        }
        for posture, positions in effector.postures.items():
            own = dict(zip(effector.joints, positions, strict=True))
            over = overloads(model, at_start | own, efforts)
            if over:
                needs = [
                    f"'{joint}' needs {needed:.3g} of {most:.3g} {_effort_unit(model, joint)}"
                    for joint, (needed, most) in over.items()
                ]
                place = loaded.source.place("effectors", name, "postures", posture)
                diagnostics.add("CB749", place, name=posture, effector=name, needs=some(needs))


def _effort_unit(model: UrdfModel, joint: str) -> str:
    return "N" if model.joints[joint].slides else "N m"
