"""One controller: from the texts of a document to a typed triple c(phi, sigma, tau)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from cbdsl.checking.controller.agreement import Agreement
from cbdsl.checking.controller.axes import check_axes, fill_axes, read_axes
from cbdsl.checking.controller.comparison import Comparison, read_comparison
from cbdsl.checking.controller.controller_options import (
    LOOK_AT,
    MANIPULABILITY,
    ControllerSettings,
    settings_of,
)
from cbdsl.checking.controller.field_options import ControllerSpec, check_field
from cbdsl.checking.controller.influence import acting_chains
from cbdsl.checking.controller.relative_reference import check_relative
from cbdsl.checking.controller.soundness import check_numbers, check_reference, suits_body
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents import program as written
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.controller import Controller, Field, Modifier, Reference
from cbdsl.robot.resources import configuration_of
from cbdsl.types.modifier import MODIFIERS, ModifierType, declared
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import Origin, Resource
from cbdsl.types.source_record import is_pressed, owner_of, record_of
from cbdsl.types.unit import QuantityError, parse_quantity, read_quantity

# Dimension of each setting in the units of a moved tip.
_OF_TIPS = {"gain": "speed per force", "speed": "speed"}
# Name and unit of the type of joints that slide.
_SLIDING = ("configuration", "m")


def in_task_units(
    context: ProgramContext,
    steps: Steps,
    settings: ControllerSettings,
    feedback: Resource,
    effector: Resource,
) -> Outcome[ControllerSettings]:
    """Return the settings in the units of the task; unknown if their units are invalid.

    A tip that moves by dx changes its force by K dx, with the stiffness K of the robot's document.
    For the force of a hand, K is multiplied by the number of fingers. A spring moves by half its
    error, so that a gain of g m/s per N equals a gain of 2 K g per second.
    """
    stated = {key: value for key in _OF_TIPS if (value := _of_tips(context, steps, key))}
    # It is the task's own, or that of joints that slide.
    if feedback.type.name != "force" or (effector.type.name, effector.type.unit) == _SLIDING:
        stated.pop("speed", None)
    if not stated:
        return settings
    problem = _problem(feedback, effector)
    for key, value in stated.items():
        if problem:
            place = context.source.place(*steps, key)
            context.add("CB594", place, value=value, problem=problem)
    if problem:
        return UNKNOWN
    stiffness = _stiffness(context.body.document, feedback)
    if "gain" in stated:
        settings = settings._replace(gain=2.0 * stiffness * settings.gain)
    return settings._replace(tip_stiffness=stiffness) if "speed" in stated else settings


def _stiffness(robot: RobotDocument, feedback: Resource) -> float:
    """Return the change of a force per tip displacement, N/m; each fingertip is a spring."""
    source, fingers = feedback.source, 1
    if record_of(source).sums:
        fingers = len(robot.load_cells[robot.members(owner_of(source))[0]])
    # Fingers are springs in parallel, whose stiffnesses add up.
    return fingers * robot.control.contact_stiffness


def _of_tips(context: ProgramContext, steps: Steps, key: str) -> str | None:
    """Return a setting as written if it has the unit of a tip, else ``None``."""
    if not context.source.holds(*steps, key):
        return None
    value = context.source.node((*steps, key)).value
    try:
        unit = parse_quantity(value)[1] if isinstance(value, str) else None
    except QuantityError:
        return None
    return str(value) if unit is not None and unit.dimension == _OF_TIPS[key] else None


def _problem(feedback: Resource, effector: Resource) -> str:
    """Return why a force does not change as a tip moves, as a clause; empty if it does."""
    if feedback.type.name != "force" or not is_pressed(feedback.source):
        return f"'{feedback.name}' is not a force of a finger or a hand that an arm presses with"
    if effector.type.name != "position":
        return f"'{effector.name}' is a {effector.type}, and moves in {effector.type.unit}"
    return ""


def read_modifiers(
    context: ProgramContext, steps: Steps, document: written.ControllerSection, feedback: Resource
) -> tuple[Modifier, ...]:
    """Return the valid modifiers of a controller, and report the invalid ones."""
    modifiers: list[Modifier] = []
    for name, options in document.modifiers.items():
        own: Steps = (*steps, "modifiers", name)
        problem = _modifier_options(name, options, document, feedback)
        if isinstance(problem, str):
            names = list(MODIFIERS.names())
            context.add("CB531", context.source.key(*own), names=names, name=name, problem=problem)
        else:
            modifiers.append(Modifier(name, tuple(problem.items())))
    return tuple(modifiers)


def _modifier_options(
    name: str,
    options: Mapping[str, str | float],
    document: written.ControllerSection,
    feedback: Resource,
) -> str | dict[str, float]:
    """Return the options in SI units, or the error of a modifier as a clause."""
    if name not in MODIFIERS:
        return f"unknown modifier '{name}'"
    try:
        kind = MODIFIERS.get(name)
    except UsageError as error:
        return str(error)
    if MODIFIERS.is_builtin(name):
        return "it is a key of the controller itself"
    lacks_reference = bool(kind.implementation) and document.reference is None
    if lacks_reference or feedback.type.name not in kind.accepts:
        what = "it changes references" if kind.implementation else "it is for feedback"
        return f"{what} of type {' or '.join(sorted(kind.accepts))}"
    return _read_options(kind, options)


def _read_options(kind: ModifierType, options: Mapping[str, str | float]) -> str | dict[str, float]:
    if options.keys() != kind.options.keys():
        return f"its options are {', '.join(kind.options) or 'none'}"
    try:
        return {
            name: read_quantity(options[name], (dimension,) if dimension else ())
            for name, dimension in kind.options.items()
        }
    except QuantityError as error:
        return str(error)


def check_triple(
    context: ProgramContext, name: str, document: written.ControllerSection
) -> Outcome[Controller]:
    """Check one controller.

    Args:
        context: Program context.
        name: Name of the controller.
        document: Controller section.

    Returns:
        Typed controller; unknown if it has errors.
    """
    return _Triple(context, name, document).check()


class _Triple:
    def __init__(
        self, context: ProgramContext, name: str, document: written.ControllerSection
    ) -> None:
        self._context = context
        self._steps: Steps = ("controllers", name)
        self._name = name
        self._document = document

    def check(self) -> Outcome[Controller]:
        document = fill_axes(self._context, self._steps, self._document)
        self._document = document
        potential = self._potential()
        # Without a robot no resource is known, and only the potential can be checked.
        if not self._context.has_body:
            return UNKNOWN
        feedback = self._resource(document.feedback, "feedback")
        effector = self._resource(document.effector, "effector")
        steps = (*self._steps, "reference")
        # A reference that the potential does not read is an error, regardless of its value.
        is_read = isinstance(potential, Unknown) or potential.reference
        value = document.reference if is_read else None
        at = (self._context, self._steps, document)
        has_axes = isinstance(feedback, Unknown) or check_axes(*at, feedback)
        axes = read_axes(document)
        comparison = read_comparison(self._context, steps, value, axes)
        if not has_axes:
            comparison = Comparison()
        agreement = Agreement(self._context, self._steps, document, potential, comparison, effector)
        if isinstance(feedback, Unknown):
            agreement.check_without_feedback()
            return UNKNOWN
        reference = agreement.check(feedback)
        check_numbers(self._context, self._steps, document)
        # ``look_at`` has a reference of another type, to which the bounds of its feedback do not
        # apply.
        if isinstance(potential, Unknown) or potential.compares is None:
            check_reference(self._context, self._steps, reference, feedback)
        if not check_relative(self._context, self._steps, document, reference, feedback):
            return UNKNOWN
        if not self._has_tip(feedback) or not self._has_rigid_cameras(feedback):
            return UNKNOWN
        settings = settings_of(self._context, self._steps, document, feedback)
        if isinstance(potential, Unknown) or isinstance(effector, Unknown):
            return UNKNOWN
        if isinstance(settings, Unknown) or not agreement.holds:
            return UNKNOWN
        return self._fitted(potential, feedback, reference, effector, settings)

    def _fitted(
        self,
        potential: PotentialType,
        feedback: Resource,
        reference: Reference | None,
        effector: Resource,
        settings: ControllerSettings,
    ) -> Outcome[Controller]:
        """Return the controller in the units of its task, if it suits the robot's joints."""
        in_units = in_task_units(self._context, self._steps, settings, feedback, effector)
        if isinstance(in_units, Unknown):
            return UNKNOWN
        if not suits_body(self._context, self._steps, self._document, feedback, effector):
            return UNKNOWN
        return self._controller(potential, feedback, reference, effector, in_units)

    def _controller(
        self,
        potential: PotentialType,
        feedback: Resource,
        reference: Reference | None,
        effector: Resource,
        settings: ControllerSettings,
    ) -> Controller:
        document = self._document
        joints = self._context.body.effector_joints(effector)
        return Controller(
            name=self._name,
            potential=potential.name,
            feedback=feedback,
            reference=reference,
            effector=effector,
            joints=joints,
            chains=acting_chains(self._context.body, feedback, effector),
            # Without a reference, the potential tracks nothing from the environment: it only
            # conditions the robot, and is not rewarded (Section 4.2).
            rewarded=feedback.origin is Origin.ENVIRONMENT and potential.reference,
            gain=settings.gain,
            speed=settings.speed,
            acceleration=settings.acceleration,
            quiescence=settings.quiescence,
            arrival=settings.arrival,
            manipulator=self._manipulator(),
            field=self._field(potential, ControllerSpec(feedback, reference, joints)),
            modifiers=read_modifiers(self._context, self._steps, document, feedback),
            axes=read_axes(document),
            tip_stiffness=settings.tip_stiffness,
            joint_unit=configuration_of(joints, self._context.body.model).unit,
            **self._modifiers(),
        )

    def _field(self, potential: PotentialType, wish: ControllerSpec) -> Field | None:
        field = self._document.field
        self._check_residuals(potential)
        checked = check_field(self._context, self._steps, potential, field, wish)
        return None if isinstance(checked, Unknown) else checked

    def _check_residuals(self, potential: PotentialType) -> None:
        """Report modifiers of a residual, which a potential with a field has not."""
        source = self._context.source
        for modifier, _ in declared(self._document):
            if potential.field and modifier.residual:
                details = {"potential": potential.name, "setting": modifier.name}
                self._context.add("CB521", source.key(*self._steps, modifier.name), **details)

    def _manipulator(self) -> str | None:
        is_manipulability = self._document.potential == MANIPULABILITY
        return self._document.manipulator or "position" if is_manipulability else None

    def _has_tip(self, feedback: Resource) -> bool:
        """Return whether the feedback has the manipulator Jacobian that manipulability needs."""
        if self._document.potential != MANIPULABILITY or feedback.type.name != "configuration":
            return True
        if self._context.body.has_tip(feedback):
            return True
        self._context.add("CB515", self._place("feedback"), name=feedback.name)
        return False

    def _has_rigid_cameras(self, feedback: Resource) -> bool:
        """Return whether two headings determine a position, with no joint between the cameras."""
        if not record_of(feedback.source).stereo or self._context.body.has_rigid_cameras():
            return True
        self._context.add("CB516", self._place("feedback"), robot=self._context.body.document.name)
        return False

    def _modifiers(self) -> dict[str, Any]:
        """Return the built-in modifiers, by their field of ``Controller``."""
        own = {
            modifier.name: modifier.read(section, partial(self._call, modifier.name))
            for modifier, section in declared(self._document)
        }
        # A look_at controller points an axis of its tip at the target.
        return {"free_axis": "z", **own} if self._document.potential == LOOK_AT else own

    def _call(self, modifier: str, text: str | None, option: str) -> str | None:
        """Return another controller's name, written as the actions call it."""
        steps = (*self._steps, modifier, option) if option else (*self._steps, modifier)
        parsed = UNKNOWN if text is None else self._context.parse(text, steps)
        return None if isinstance(parsed, Unknown) else str(parsed)

    def _place(self, *steps: str | int) -> Place:
        return self._context.source.place(*self._steps, *steps)

    def _potential(self) -> Outcome[PotentialType]:
        name = self._document.potential
        potential = POTENTIALS.get(name)
        if potential is None:
            place = self._place("potential")
            reason = POTENTIALS.registry.missing().get(name, f"unknown potential '{name}'")
            self._context.add("CB502", place, names=list(POTENTIALS), name=name, reason=reason)
            return UNKNOWN
        return potential

    def _resource(self, text: str, key: str) -> Outcome[Resource]:
        return self._context.resource(text, (*self._steps, key))
