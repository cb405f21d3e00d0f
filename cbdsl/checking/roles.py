"""Binding of a program's roles to the effectors of a robot (Sections 8.2 and 8.3)."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.role_effectors import bindings, groups_of, unfilled
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.nearest import suggestion
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.program import ProgramDocument, Use
from cbdsl.documents.robot import Effector, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.language.expression import SUBJECT_TO
from cbdsl.types.relative import (
    ANY_ROBOT,
    length_text,
    named,
    parts_in,
    replaced,
    with_measures,
    with_parts,
)
from cbdsl.types.role import EYES, ROBOT, Role, role
from cbdsl.types.unit import QuantityError
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.shared_calls import has_call, terms_of, validated


def without_absent(data: dict[str, Any], absent: Collection[str]) -> dict[str, Any]:
    """Return a program's values without the controllers of roles that nothing fills.

    ``otherwise`` of such a controller takes its place. Compositions and the background lose the
    other ones, and models that only these draw from are left out.

    Args:
        data: Values of the document.
        absent: Names of the roles.
    """
    controllers, gone = dict(data.get("controllers", {})), set[str]()

    def rest(text: str) -> str:
        terms = [str(each) for each in terms_of(text)]
        kept = [each for each in terms if not parts_in(each) & {*absent} and each not in gone]
        return SUBJECT_TO.join(kept) if terms else text  # its check reports a text without terms

    for name, each in data.get("controllers", {}).items():
        if isinstance(each, dict):
            own = {key: value for key, value in each.items() if key != "otherwise"}
            lacks = parts_in(own) & {*absent} or own.get("effector") in absent
            controllers[name] = each.get("otherwise", "") if lacks else own
    for _ in controllers if absent else ():  # compositions of compositions
        short = {k: v if isinstance(v, dict) else rest(v) for k, v in controllers.items()}
        controllers = {name: each for name, each in short.items() if each}
        gone |= {name for name, each in short.items() if not each}
    kept = {**data, "controllers": controllers, "background": rest(data.get("background") or "")}
    words = {*re.findall(r"\w+", str({**kept, "models": ()}))} if absent else data.get("models", ())
    kept["models"] = {key: each for key, each in data.get("models", {}).items() if key in words}
    return {key: each for key, each in kept.items() if each or key in {*data} - {"background"}}


def read_roles(document: ProgramDocument) -> dict[str, Role]:
    """Return the roles of a program that can be read and relate to earlier ones, by name."""
    roles: dict[str, Role] = {}
    for name, text in document.roles.items():
        own = role(text, roles)
        if own is not None and roles.keys() >= set(own.relations.values()):
            roles[name] = own
    return roles


def roles_on(
    robot: CheckedRobot, document: ProgramDocument, values: Mapping[str, str]
) -> dict[str, Role]:
    """Return the roles of a program, without optional ones that neither robot nor value fills."""
    return {
        name: each
        for name, each in read_roles(document).items()
        if not (each.optional and name not in values and unfilled(name, each, robot, {}))
    }


def check_roles(loaded: Loaded[ProgramDocument], diagnostics: Diagnostics) -> None:
    """Check that each role has a known kind, and relates to an earlier role."""
    document, source = loaded.document, loaded.source
    if source.holds("robot"):
        related = [(source.key("roles"), "the roles")]
        diagnostics.add("CB415", source.key("robot"), related=related, name=document.robot)
    known = read_roles(document)
    for place, (name, text) in enumerate(document.roles.items()):
        earlier, at = list(document.roles)[:place], source.place("roles", name)
        own = role(text, {each: known[each] for each in earlier if each in known})
        if own is None:
            problem = f"'{text}' is no kind of effector"
            diagnostics.add("CB413", at, name=name, problem=problem)
        elif wrong := sorted({*own.relations.values()}.difference(earlier)):
            problem = f"role '{', '.join(wrong)}' is not stated above"
            diagnostics.add("CB413", at, names=earlier, name=name, problem=problem)
        if source.holds("parameters", name):
            related = [(source.key("parameters", name), "the parameter")]
            details = {"name": name, "other": "parameter"}
            diagnostics.add("CB703", source.key("roles", name), related=related, **details)


def bind(
    loaded: Loaded[ProgramDocument],
    robot: CheckedRobot,
    values: Mapping[str, str],
    measures: Callable[[tuple[str, ...]], Mapping[str, float]] = lambda _: {},
) -> Loaded[ProgramDocument] | str:
    """Return a program with effectors of a robot in its roles, or the reason why there are none.

    An effector with the name of a role comes first, then the effector that the robot's document
    names for it. Several effectors that remain equal are a reason to refuse.

    Args:
        loaded: Program with roles.
        robot: Robot.
        values: Given effectors by role, and other values.
        measures: Function of the effectors that returns the measures of the robot and its bench by
            name, m.
    """
    document, roles = loaded.document, roles_on(robot, loaded.document, values)
    absent = document.roles.keys() - roles.keys()
    for name, each in roles.items():
        problem = unfilled(name, each, robot, values)
        if problem:
            return problem
    every = list(bindings(roles, robot, values))
    fitting = [each.effectors for each in every if not each.refusal]
    if not fitting:
        return f"robot '{robot.document.name}' does not fill the roles: {every[0].refusal}"
    best = _preferred(fitting, robot.document.roles)
    if len(best) > 1:
        name = next(name for name in roles if len({each[name] for each in best}) > 1)
        listed = " or ".join(dict.fromkeys(f"{name}={each[name]}" for each in best))
        return (
            f"robot '{robot.document.name}' fills role '{name}' in several ways: choose {listed}, "
            "or name one in 'roles' of its document"
        )
    effectors = {name: value for name, value in best[0].items() if roles[name].wanted.kind != EYES}
    acting = tuple(effectors.values())
    whole = loaded.source.root.plain()
    data = without_absent(whole, absent) if isinstance(whole, dict) else whole
    stated = _with_values(loaded, data, robot, best[0], effectors, lambda: measures(acting))
    if isinstance(stated, str):
        return stated
    update = {
        "robot": robot.document.name,
        "parameters": {**stated.parameters, **effectors},
        "resources": {**stated.resources, **groups_of(document, roles)},
    }
    return loaded._replace(document=stated.model_copy(update=update))


def _with_values(
    loaded: Loaded[ProgramDocument],
    data: Any,
    robot: CheckedRobot,
    chosen: Mapping[str, str],
    effectors: Mapping[str, str],
    measures: Callable[[], Mapping[str, float]],
) -> ProgramDocument | str:
    """Return a program with the values of a robot's document, or the reason against that robot."""
    known = robot.document.effectors
    if not isinstance(data, dict):
        return loaded.document
    texts = {role: name for role, name in chosen.items() if role not in effectors}
    texts |= {
        f"{role}.{key}": text
        for role, name in effectors.items()
        if name in known
        for key, text in _texts(role, known[name]).items()
    }

    def on_the_robot(text: str) -> str | float:
        # A call is the name of its declaration, in which its arguments stand.
        is_name = has_call(text, loaded.taken)
        return text if is_name else with_measures(with_parts(text, texts), measures)

    try:
        bound = replaced(data, on_the_robot)
        for section in {"parameters", "use"} & {*data}:
            # Values of parameters are texts.
            bound[section] = replaced(data[section], lambda text: length_text(on_the_robot(text)))
        calls = {
            section: {name: bound[section].pop(name) for name in loaded.taken & {*bound[section]}}
            for section in ("controllers", "conditions")
            if section in bound
        }
        document = ProgramDocument.model_validate(bound, context={"folder": loaded.path.parent})
        update = {
            section: getattr(document, section)
            | {name: validated(value, relative=False) for name, value in entries.items()}
            for section, entries in calls.items()
        }
        fields = vars(loaded.document).items()
        update |= {name: value for name, value in fields if isinstance(value, Unknown)}
        return document.model_copy(update=update)
    except QuantityError as error:
        return f"robot '{robot.document.name}' does not suit the program: {error}"
    except ValidationError as error:
        return _lacking(error, robot, effectors)


def _texts(role: str, effector: Effector) -> dict[str, str]:
    """Return the values of an effector, and the posture that it starts in as ``start``."""
    start = effector.start
    begins = {} if start is None or "start" in effector.postures else {"start": f"${role}.{start}"}
    return begins | effector.values


def _lacking(error: ValidationError, robot: CheckedRobot, effectors: Mapping[str, str]) -> str:
    """Return which value of a robot's document a program lacks, or which one does not suit it."""
    first, document = error.errors(include_url=False)[0], robot.document
    # Tags of unions are in a location, and not in the text.
    steps = [str(step) for step in first["loc"] if not str(step)[:1].isupper()]
    where, given = ".".join(steps), first["input"]
    name = next(iter(named(given)), "")
    role, _, key = name.partition(".")
    if role not in effectors:
        return f"robot '{document.name}' does not suit {where}: {first['msg']}"
    return _states_no(key, effectors[role], robot, where)


def _states_no(key: str, effector: str, robot: CheckedRobot, where: str) -> str:
    known = robot.document.effectors.get(effector)
    values = {} if known is None else known.values
    return (
        f"robot '{robot.document.name}' states no value '{key}' of '{effector}', which {where} "
        f"needs{suggestion(key, values)}; write it in 'values' of that effector (it states "
        f"{', '.join(values) or 'none'})"
    )


def _preferred(
    fitting: Sequence[Mapping[str, str]], names: Mapping[str, str]
) -> list[Mapping[str, str]]:
    """Return the choices with the most roles that have the effector that the robot names."""
    ranks = [[(e == name, e == names.get(name)) for name, e in each.items()] for each in fitting]
    return [each for each, rank in zip(fitting, ranks, strict=True) if rank == max(ranks)]


def bound_program(
    loaded: Loaded[ProgramDocument],
    values: Mapping[str, str],
    session: Session,
    diagnostics: Diagnostics,
) -> Outcome[Loaded[ProgramDocument]]:
    """Return a program with the effectors of a robot in its roles; the library keeps it.

    Args:
        loaded: Program with roles.
        values: Given robot, effectors by role, and other values.
        session: Session with the documents read so far.
        diagnostics: Diagnostics so far.

    Returns:
        Program on the given robot, or on the first one at hand that fits; unknown if none does.
    """
    # Faults of other parts, which are left out of the program, do not concern its roles.
    faults = Diagnostics()
    check_roles(loaded, faults)
    diagnostics.extend(faults.sorted())
    if faults.failed:
        return UNKNOWN
    reasons, names = [], _first_the_stage_s(loaded, session.library)
    if ROBOT in values:
        names = [values[ROBOT]]
        file = session.library.find(RobotDocument, values[ROBOT], loaded.path)
        if file is not None and isinstance(session.body(file, diagnostics), Unknown):
            return UNKNOWN
    for name in names:
        bound = on_robot(name, loaded, values, session)
        if isinstance(bound, Loaded):
            session.library.bind(bound)
            return bound
        reasons.append(bound)
    place, problem = loaded.source.key("roles"), "; ".join(reasons) or "no robot"
    diagnostics.add("CB414", place, name=loaded.document.name, problem=problem)
    return UNKNOWN


def without_roles(
    loaded: Loaded[ProgramDocument], robot: str, session: Session
) -> Loaded[ProgramDocument]:
    """Return the program of one robot that a program with roles stands for.

    Args:
        loaded: Program with roles.
        robot: Robot; the first one at hand that fits if empty.
        session: Session with the documents read so far.

    Returns:
        Program; as written if the robot does not fit.
    """
    for name in [robot] if robot else _first_the_stage_s(loaded, session.library):
        bound = on_robot(name, loaded, {}, session)
        if isinstance(bound, Loaded):
            return bound._replace(document=bound.document.model_copy(update={"roles": {}}))
    return loaded


def on_robot(
    name: str, loaded: Loaded[ProgramDocument], values: Mapping[str, str], session: Session
) -> Loaded[ProgramDocument] | str:
    """Return a program with the effectors of a named robot, or the reason against that robot."""
    library = session.library
    file = library.find(RobotDocument, name, loaded.path)
    if file is None:
        known = library.names(RobotDocument, loaded.path)
        return f"there is no robot '{name}'{suggestion(name, known)} (known: {', '.join(known)})"
    body = session.body(file, Diagnostics())
    if isinstance(body, Unknown):
        return f"robot '{name}' has errors, which 'cb validate {file}' lists"

    @cache
    def measures(parts: tuple[str, ...]) -> Mapping[str, float]:
        from cbdsl.kinematics.bench import measures_of  # few programs need it

        return measures_of(body.document, file, parts)

    bound = bind(loaded, body, values, measures)
    if isinstance(bound, str):
        return bound
    if lacking := _unstated(loaded, bound.document, body, session):
        return lacking
    use = {key: _suitable(each, name, loaded, session) for key, each in bound.document.use.items()}
    stage = _stage(bound.document, name, loaded.path, library)
    document = bound.document.model_copy(update={"use": use, "stage": stage, "stages": ()})
    return bound._replace(document=document)


def _unstated(
    loaded: Loaded[ProgramDocument], bound: ProgramDocument, robot: CheckedRobot, session: Session
) -> str:
    """Return which value a robot lacks that another robot at hand states; empty if none."""
    effectors = robot.document.effectors
    # The text also names the values of faulty parts, which are left out of the source.
    whole = session.library.text(loaded.path) if loaded.diagnostics else loaded.source.root.plain()
    for name in dict.fromkeys(named(whole)):
        role, _, key = name.partition(".")
        own = bound.parameters.get(role, "")
        if role not in loaded.document.roles or own not in effectors:
            continue
        is_known = key in effectors[own].values or any(
            f"{each}.".startswith(f"{own}.{key}.") for each in robot.resources
        )
        if not is_known and key in _stated(loaded.path, session):
            return _states_no(key, own, robot, "the program")
    return ""


def _stated(path: Path, session: Session) -> set[str]:
    """Return the names of the values that robots at hand state."""
    library, robots = session.library, []
    for name in library.names(RobotDocument, path):
        with suppress(DiagnosticsError):
            if (file := library.find(RobotDocument, name, path)) is not None:
                robots.append(library.read_sound_parts(file, RobotDocument).document)
    return {key for robot in robots for each in robot.effectors.values() for key in each.values}


def _suitable(use: Use, robot: str, loaded: Loaded[ProgramDocument], session: Session) -> Use:
    """Return the first use among alternatives whose program a robot can run, or the last one."""
    while use.otherwise is not None and not _runs(use.program, robot, loaded, session):
        use = use.otherwise
    return use.model_copy(update={"otherwise": None})


def _runs(name: str, robot: str, loaded: Loaded[ProgramDocument], session: Session) -> bool:
    """Return whether a program is for a robot, or over roles that it fills."""
    file = session.library.find(ProgramDocument, name, loaded.path)
    if file is None or session.library.real(file) == session.library.real(loaded.path):
        return True  # a finding of its own
    try:
        used = session.library.read_as_written(file, ProgramDocument)
    except DiagnosticsError:
        return True
    if used.document.roles:
        return isinstance(on_robot(robot, used, {}, session), Loaded)
    return used.document.robot == robot


def _stage(document: ProgramDocument, robot: str, path: Path, library: Library) -> str | None:
    """Return the first stage of a program that suits a robot; its own if it has no others."""
    if not document.stages:
        return document.stage
    for name in (document.stage, *document.stages):
        if name is not None and _robot_of(name, path, library) in (robot, ANY_ROBOT, None):
            return name
    return None


def _robot_of(stage: str, path: Path, library: Library) -> str | None:
    """Return the robot of a stage, `any` if it is for any; ``None`` if it cannot be read."""
    file = library.find(StageDocument, stage, path)
    try:
        return None if file is None else library.read(file, StageDocument).document.robot
    except DiagnosticsError:
        return None


def _first_the_stage_s(loaded: Loaded[ProgramDocument], library: Library) -> list[str]:
    """Return the robots at hand, the one of the program's own stage first."""
    names, stage = library.names(RobotDocument, loaded.path), loaded.document.stage
    own = None if stage is None else _robot_of(stage, loaded.path, library)
    return sorted(names, key=lambda name: name != own)


def fitting_robots(loaded: Loaded[ProgramDocument], session: Session) -> list[str]:
    """Return the names of the robots at hand that fill the roles of a program."""
    return [
        name
        for name in session.library.names(RobotDocument, loaded.path)
        if isinstance(on_robot(name, loaded, session.values, session), Loaded)
    ]
