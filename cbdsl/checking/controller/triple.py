"""One controller: from the texts of a document to a typed triple c(phi, sigma, tau)."""

from __future__ import annotations

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
from cbdsl.checking.controller.effector_units import in_task_units
from cbdsl.checking.controller.field_options import ControllerSpec, check_field
from cbdsl.checking.controller.influence import acting_chains
from cbdsl.checking.controller.modifiers import read_modifiers
from cbdsl.checking.controller.relative_reference import check_relative
from cbdsl.checking.controller.soundness import check_numbers, check_reference, suits_body
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents import program as written
from cbdsl.program.controller import Controller, Field, Reference
from cbdsl.robot.resources import configuration_of
from cbdsl.types.modifier import declared
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import Origin, Resource
from cbdsl.types.source_record import record_of


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
