"""Guards of a program: loads that are measured beyond noise, distances that the start keeps."""

from __future__ import annotations

from cbdsl.checking.load_noise import least_force
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.session import Session
from cbdsl.checking.stage.fixture_hulls import fixture_hull
from cbdsl.checking.start_clearance import unkept_clearance
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Unknown
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource import Origin, Resource
from cbdsl.yaml_text.loaded import Loaded


def check_guards(context: ProgramContext) -> tuple[tuple[Resource, ...], tuple[str, ...]]:
    """Report bounds that noise alone exceeds, and bounds of a robot without load cells.

    Returns:
        Seen objects from which links keep the clearance, and names of fixtures.
    """
    if not context.has_body:
        return (), ()
    _check_loads(context)
    _check_joint_torque(context)
    _check_clearance(context)
    return _avoided(context)


def _check_loads(context: ProgramContext) -> None:
    guards, source = context.document.guards, context.source
    robot = context.body.document
    # Loads up to this force are taken for noise, so that a lower bound could not be enforced.
    least = least_force(robot)
    for key in ("finger_force", "hand_force"):
        bound = getattr(guards, key)
        if bound is None:
            continue
        place = source.place("guards", key)
        if not robot.load_cells:
            problem = f"'{robot.name}' has no load cells to measure it"
            context.add("CB587", place, problem=problem)
        elif 0 < bound <= least:
            problem = f"{bound:g} N is within the noise of its load cells, {least:g} N"
            context.add("CB587", place, problem=problem)


def _check_joint_torque(context: ProgramContext) -> None:
    """Report a bound on torques that no joint measures, or that motion alone exceeds."""
    robot, bound = context.body.document, context.document.guards.joint_torque
    if bound is None:
        return
    place, settings = context.source.place("guards", "joint_torque"), robot.joint_torques
    if settings is None:
        problem = f"the drives of '{robot.name}' measure no torques ('joint_torques')"
        context.add("CB587", place, problem=problem)
    elif 0 < bound <= settings.threshold:
        least = f"{settings.threshold:g} N m"
        problem = f"motion without contact may cause up to {least}, and the bound is {bound:g} N m"
        context.add("CB587", place, problem=problem)


def _check_clearance(context: ProgramContext) -> None:
    """Report a distance that links do not keep in the start posture."""
    least, model = context.document.guards.clearance, context.body.model
    if least is None or model is None:
        return
    if problem := unkept_clearance(context.body.document, model, least):
        context.add("CB587", context.source.place("guards", "clearance"), problem=problem)


def _avoided(context: ProgramContext) -> tuple[tuple[Resource, ...], tuple[str, ...]]:
    """Return the seen objects and the fixtures that links keep away from."""
    guards = context.document.guards
    seen, fixtures = list[Resource](), list[str]()
    for place, text in enumerate(guards.avoid):
        steps: Steps = ("guards", "avoid", place)
        name = context.substitute(text, steps)
        if isinstance(name, Unknown):
            continue
        if "." not in name:
            fixtures.append(name)
            continue
        resource = context.resource(text, steps)
        if isinstance(resource, Unknown):
            continue
        if resource.type.name == "position" and resource.origin is Origin.TRIANGULATION:
            seen.append(resource)
        else:
            problem = f"'{name}' is no position of a seen object"
            context.add("CB587", context.source.place(*steps), problem=problem)
    if guards.avoid and guards.clearance is None:
        problem = "'avoid' needs the distance 'clearance' beside it"
        context.add("CB587", context.source.place("guards", "avoid"), problem=problem)
    return tuple(seen), tuple(fixtures)


def check_fixtures(
    loaded: Loaded[ProgramDocument],
    program: CheckedProgram,
    session: Session,
    diagnostics: Diagnostics,
) -> None:
    """Report fixtures to keep away from that the stage of a sound program does not have."""
    if not program.guards.fixtures:
        return
    library = session.library
    path = library.find(StageDocument, program.stage or "", loaded.path)
    stage = session.read(path, StageDocument, diagnostics) if path else UNKNOWN
    if isinstance(stage, Unknown):
        return
    for name in program.guards.fixtures:
        hull = fixture_hull(name, stage.document)
        if isinstance(hull, str):
            diagnostics.add("CB587", loaded.source.place("guards", "avoid"), problem=hull)
