"""Programs to assimilate: all allocations of a program under a policy, and its features."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from cbdsl.checking.allocations import allocations
from cbdsl.checking.knowledge.policy_agreement import with_policy
from cbdsl.checking.prior_looks import derived_looks
from cbdsl.checking.program import examiner
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.checking.substitution import Allocation
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.allocated_program import allocate
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Controller, Relative
from cbdsl.program.schema import Schema
from cbdsl.program.state_values import state_values
from cbdsl.robot.resources import FROM
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import Carrier, is_located, owner_of, record_of
from cbdsl.yaml_text.loaded import Loaded

# First-order dynamics of a seen object (Section 5.3.1.1), by name of the feature.
_DYNAMICS = {"place": "", "velocity": ".velocity", "volume": ".volume"}


def program_to_assimilate(
    path: Path,
    policy: Loaded[PolicyDocument],
    session: Session,
    values: Mapping[str, str],
    least: int = 2,
) -> CheckedProgram:
    """Return a program with all its allocations, without any learned choice between them.

    Args:
        path: File of a program without diagnostics.
        policy: Declarative policy without diagnostics.
        session: Session with the documents read so far.
        values: Values of the program's parameters.
        least: Fewest allocations that have to fit.

    Raises:
        UsageError: Fewer allocations fit, or no controller uses a seen position.
    """
    fitting = _fitting(path, session, values)
    if len(fitting) < least:
        raise UsageError(
            f"{path}: there is nothing to choose: of its resources one allocation fits; "
            f"see cb show allocations {path.stem}"
        )
    variants = {
        name: with_policy(program, policy, session.library)
        for name, (program, _) in fitting.items()
    }
    base = next(iter(variants.values()))
    robot = _robot(base, path, session)
    features = {} if isinstance(robot, Unknown) else _features(base, robot.resources)
    places = _places(features)
    if not isinstance(robot, Unknown) and len(places) == 1:
        (only,) = places.values()
        features |= _distances(only, variants.values(), robot)
    if not features:
        raise UsageError(f"{path}: no seen position, so no context to learn; see cb run --policy")
    worth = state_values(policy.document.policy, policy.document.transitions)
    allotted = {name: values for name, (_, values) in fitting.items()}
    # The program looks for the last object first: that is the object it takes first.
    last_first = dict(reversed(places.items()))
    looks = derived_looks(base, last_first, path, session, examiner(session))
    schema = Schema(
        policy.document.name, features, allotted, otherwise=tuple(variants), worth=worth
    )
    return allocate(variants, schema)._replace(looks=looks)


def variants_of(
    path: Path, session: Session, values: Mapping[str, str]
) -> dict[str, CheckedProgram]:
    """Return a program under each of its ``allocations`` by name, its own one first."""
    return {name: program for name, (program, _) in _fitting(path, session, values).items()}


def _fitting(
    path: Path, session: Session, values: Mapping[str, str]
) -> dict[str, tuple[CheckedProgram, Mapping[str, str]]]:
    """Return the allocations that fit, with the values of their parameters, by name."""
    ordered = sorted(
        allocations(path, session, values), key=lambda each: not _is_default(each, path, session)
    )
    return {
        _name(each): (each.program, each.values) for each in ordered if each.program is not None
    }


def _name(allocation: Allocation) -> str:
    return "_".join(allocation.choices.values())


def _is_default(allocation: Allocation, path: Path, session: Session) -> bool:
    """Return whether an allocation has the program's values as written."""
    own = session.library.read(path, ProgramDocument).document.parameters
    return all(own.get(name) == value for name, value in allocation.values.items())


def _robot(program: CheckedProgram, path: Path, session: Session) -> Outcome[CheckedRobot]:
    file = session.library.find(RobotDocument, program.robot, path)
    return session.body(file or UNKNOWN, Diagnostics())


def _features(program: CheckedProgram, known: Mapping[str, Resource]) -> dict[str, Resource]:
    """Return the position, velocity and volume of the object that the program's controllers see.

    For several objects, return only their positions, x_obj and x_goal of Section 7.1.2. Obstacles
    of a field are not objects that the program acts on.
    """
    seen = dict.fromkeys(
        resource
        for primitive in program.primitives.values()
        for controller in primitive.controllers
        for resource in _compared(controller)
        if is_located(resource.source)
    )
    if len(seen) == 1:
        (only,) = seen
        return {
            name: known[only.name + suffix]
            for name, suffix in _DYNAMICS.items()
            if only.name + suffix in known
        }
    by_channel = {value: name for name, value in program.parameters.items()}
    channels = {resource: resource.name.partition(".")[2] for resource in seen}
    return {
        f"{by_channel.get(channel, channel)}_place": known[resource.name]
        for resource, channel in channels.items()
    }


def _places(features: Mapping[str, Resource]) -> dict[str, Resource]:
    """Return the features that are positions of seen objects."""
    return {name: each for name, each in features.items() if is_located(each.source)}


def _distances(
    place: Resource, variants: Iterable[CheckedProgram], robot: CheckedRobot
) -> dict[str, Resource]:
    """Return the distance of a seen object from the bases of the effectors that may reach for it.

    One feature is enough if the robot has a group of just these effectors.
    """
    reaching = frozenset(
        member
        for program in variants
        for primitive in program.primitives.values()
        for controller in primitive.controllers
        for member in _tipped(controller.effector, robot)
    )
    groups = robot.document.groups.items()
    together = [name for name, group in groups if reaching == set(group.members)]
    names = together[:1] or sorted(reaching)
    return {
        "distance" if len(names) == 1 else f"distance_{name}": robot.resources[signal]
        for name in names
        if (signal := f"{place.name}.{FROM}.{name}") in robot.resources
    }


def _tipped(effector: Resource, robot: CheckedRobot) -> tuple[str, ...]:
    """Return the effectors whose tips a controller moves."""
    source = effector.source
    is_tipped = Carrier.TIPS in record_of(source).carriers
    return robot.document.members(owner_of(source)) if is_tipped else ()


def _compared(controller: Controller) -> tuple[Resource, ...]:
    """Return the resources that a controller compares: its feedback and its reference."""
    reference = controller.reference
    base = reference.base if isinstance(reference, Relative) else reference
    return (controller.feedback, *((base,) if isinstance(base, Resource) else ()))
