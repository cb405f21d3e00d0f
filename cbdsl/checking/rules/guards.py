"""Guards of a program: loads that are measured beyond noise, distances that the start keeps."""

from __future__ import annotations

from cbdsl.checking.load_noise import least_force
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.stage.fixture_hulls import fixture_hull
from cbdsl.checking.start_clearance import unkept_clearance
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.program.checked import CheckedProgram, fixtures_of
from cbdsl.robot.resources import FROM
from cbdsl.types.resource import Origin, Resource
from cbdsl.yaml_text.source_map import SourceMap


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
    source: SourceMap,
    program: CheckedProgram,
    stage: StageDocument,
    robot: RobotDocument,
    diagnostics: Diagnostics,
) -> None:
    """Report the fixtures of a sound program's links that its stage does not have."""
    for name in fixtures_of(program):
        hull = fixture_hull(name, stage)
        if not isinstance(hull, str):
            continue
        if name in program.guards.fixtures:
            diagnostics.add("CB587", source.place("guards", "avoid"), problem=hull)
            continue
        texts = {key: each.text for key, each in program.conditions.items()}
        at = next((("conditions", key) for key, text in texts.items() if name in text), ("stage",))
        names = [*robot.all_effectors, *robot.clearance.keep_out, *stage.fixtures]
        details = {"name": f"{FROM}.{name}", "robot": robot.name, "hint": f"; {hull}"}
        diagnostics.add("CB501", source.place(*at), names=names, given=name, **details)
