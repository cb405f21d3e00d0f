"""One controller: from the texts of a document to a typed triple c(phi, sigma, tau)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeVar

from cbdsl.checking.context import Context, Steps
from cbdsl.checking.field import Wish, check_field
from cbdsl.checking.references import LiteralError, is_literal, read_literal
from cbdsl.checking.scope import Scope
from cbdsl.checking.settings import check_settings
from cbdsl.checking.soundness import check_numbers, check_reference, suits_body
from cbdsl.documents import program as written
from cbdsl.documents.robot import TaskSettings
from cbdsl.errors.diagnostic import Place
from cbdsl.program.controller import (
    Controller,
    Field,
    Funnel,
    Quiescence,
    Reference,
    Seek,
    Standoff,
)
from cbdsl.types.casts import Cast, chains, held_chain
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import FingerForces, Headings, NetForces, Origin, Resource, Tip
from cbdsl.types.resource_type import TYPES
from cbdsl.yaml_text.faults import decimal_comma

_MANIPULABILITY = "manipulability"


class _Settings(NamedTuple):
    """What the robot's settings and the controller's own come to."""

    gain: float
    speed: float | None
    acceleration: float | None
    quiescence: Quiescence


def check_triple(
    context: Context, key: str, name: str, document: written.Controller, scope: Scope
) -> Controller | None:
    """Check one controller.

    Args:
        context: the program.
        key: the controller's key in the document.
        name: what it is called, with its arguments.
        document: its fields.
        scope: values of the program's and the controller's parameters.

    Returns:
        ``None`` where it has faults.
    """
    return _Triple(context, key, name, document, scope).check()


class _Triple:
    def __init__(
        self, context: Context, key: str, name: str, document: written.Controller, scope: Scope
    ) -> None:
        self._context = context
        self._steps: Steps = ("controllers", key)
        self._name = name
        self._document = document
        self._scope = scope

    def check(self) -> Controller | None:
        document = self._document
        potential = self._potential()
        if not self._context.has_body:
            return None
        feedback = self._resource(document.feedback, "feedback")
        effector = self._resource(document.effector, "effector")
        reference = self._reference(feedback)
        if potential is not None:
            self._reference_wanted(potential)
        if feedback is None:
            return None
        if potential is not None:
            self._accepts(potential, feedback)
        self._options(feedback)
        check_numbers(self._context, self._steps, document)
        check_reference(self._context, self._steps, reference, feedback)
        if document.potential == _MANIPULABILITY and not self._has_tip(feedback):
            return None
        if isinstance(feedback.source, Headings) and not self._has_rigid_cameras():
            return None
        settings = self._settings(feedback)
        if effector is None or not self._moves(effector, feedback):
            return None
        if settings is None or potential is None or self._lacks(potential, reference):
            return None
        if not suits_body(self._context, self._steps, document, feedback, effector):
            return None
        return self._controller(potential, feedback, reference, effector, settings)

    def _controller(
        self,
        potential: PotentialType,
        feedback: Resource,
        reference: Reference | None,
        effector: Resource,
        settings: _Settings,
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
            chain=self._chain(feedback, effector),
            rewarded=feedback.origin is Origin.ENVIRONMENT,
            gain=settings.gain,
            speed=settings.speed,
            acceleration=settings.acceleration,
            quiescence=settings.quiescence,
            free_axis=document.free_axis,
            manipulator=self._manipulator(),
            standoff=_standoff(document.standoff),
            funnel=_funnel(document.funnel),
            seek=self._seek(),
            field=self._field(potential, Wish(feedback, reference, joints)),
        )

    def _field(self, potential: PotentialType, wish: Wish) -> Field | None:
        field, source = self._document.field, self._context.source
        if potential.field and self._document.funnel is not None:
            details = {"potential": potential.name, "setting": "funnel"}
            self._context.add("CB521", source.key(*self._steps, "funnel"), **details)
        return check_field(self._context, self._steps, potential, field, wish, self._scope)

    def _chain(self, feedback: Resource, effector: Resource) -> tuple[str, ...]:
        """How a displacement of the feedback becomes one of the effector, for people."""
        body = self._context.body
        sensed = body.sensing(feedback)
        if sensed is not None and sensed.isdisjoint(body.effector_joints(effector)):
            return _spelled(held_chain(feedback.type, effector.type), feedback, effector)
        return _spelled(chains(feedback.type, effector.type)[0], feedback, effector)

    def _manipulator(self) -> str | None:
        is_manipulability = self._document.potential == _MANIPULABILITY
        return self._document.manipulator or "position" if is_manipulability else None

    def _has_tip(self, feedback: Resource) -> bool:
        """Whether there is a manipulator Jacobian that a manipulability can be of."""
        if feedback.type.name != "configuration" or self._context.body.has_tip(feedback):
            return True
        self._context.add("CB515", self._place("feedback"), name=feedback.name)
        return False

    def _has_rigid_cameras(self) -> bool:
        """Whether two headings tell where something is, with no joint between the cameras."""
        if self._context.body.has_rigid_cameras():
            return True
        self._context.add("CB516", self._place("feedback"), robot=self._context.body.document.name)
        return False

    def _seek(self) -> Seek | None:
        seek = self._document.seek
        if seek is None:
            return None
        steps: Steps = (*self._steps, "seek", "once")
        once = None if seek.once is None else self._context.parse(seek.once, steps)
        return Seek(None if once is None else str(once), seek.within, seek.until)

    def _place(self, *steps: str | int) -> Place:
        return self._context.source.place(*self._steps, *steps)

    def _potential(self) -> PotentialType | None:
        name = self._document.potential
        potential = POTENTIALS.get(name)
        if potential is None:
            place = self._place("potential")
            self._context.add("CB502", place, names=list(POTENTIALS), name=name)
        return potential

    def _resource(self, text: str, key: str) -> Resource | None:
        return self._context.resource(text, (*self._steps, key), self._scope)

    def _reference_wanted(self, potential: PotentialType) -> None:
        given = self._document.reference is not None
        if potential.reference and not given:
            key = self._context.source.key(*self._steps)
            self._context.add("CB509", key, potential=potential.name)
        if given and not potential.reference:
            self._context.add("CB510", self._place("reference"), potential=potential.name)

    def _reference(self, feedback: Resource | None) -> Reference | None:
        value = self._document.reference
        if isinstance(value, str):
            text = self._context.substitute(value, (*self._steps, "reference"), self._scope)
            if text is None:
                return None
            if not is_literal(text):
                return self._compared(self._resource(value, "reference"), feedback)
            value = text
        if value is None or feedback is None:
            return None
        try:
            return read_literal(value, feedback)
        except LiteralError as error:
            steps = (*self._steps, "reference")
            comma = decimal_comma(self._context.source.node(steps))
            if comma is not None and error.code == "CB505":
                self._context.add("CB506", self._place("reference"), problem=comma)
                return None
            item = () if error.item is None else (error.item,)
            place = self._place("reference", *item)
            self._context.add(error.code, place, **error.details)
            return None

    def _compared(self, reference: Resource | None, feedback: Resource | None) -> Resource | None:
        """A reference of the feedback's type."""
        if reference is None or feedback is None or reference.type == feedback.type:
            return reference
        body = self._context.body
        self._context.add(
            "CB504",
            self._place("reference"),
            related=[
                (self._place("feedback"), f"the feedback, {feedback.type}"),
                *(
                    (body.declaration(resource), f"where '{resource.name}' comes from")
                    for resource in (reference, feedback)
                ),
            ],
            reference=reference.name,
            reference_type=reference.type,
            feedback=feedback.name,
            feedback_type=feedback.type,
        )
        return None

    def _lacks(self, potential: PotentialType, reference: Reference | None) -> bool:
        return potential.reference != (reference is not None)

    def _accepts(self, potential: PotentialType, feedback: Resource) -> None:
        factors = potential.factors or feedback.type.factors
        if feedback.type.name not in potential.accepts or feedback.type.factors != factors:
            self._context.add(
                "CB503",
                self._place("feedback"),
                names=sorted(potential.accepts),
                related=[(self._place("potential"), "the potential")],
                potential=potential.name,
                feedback=feedback.type,
                name=feedback.name,
            )

    def _moves(self, effector: Resource, feedback: Resource) -> bool:
        """Whether the effector can be moved, and moves the feedback."""
        place = self._place("effector")
        if not effector.movable:
            names = [r.name for r in self._context.body.resources.values() if r.movable]
            self._context.add("CB507", place, names=names, name=effector.name)
            return False
        influence = self._context.body.influence(feedback)
        joints = self._context.body.effector_joints(effector)
        if not chains(feedback.type, effector.type) or (
            influence is not None and influence.isdisjoint(joints)
        ):
            related = [(self._place("feedback"), f"'{feedback.name}' is {feedback.type}")]
            ends = {"effector": effector.name, "feedback": feedback.name}
            self._context.add("CB508", place, related=related, **ends)
            return False
        return True

    def _options(self, feedback: Resource) -> None:
        """Options have to mean something for the feedback."""
        document = self._document
        is_position = isinstance(feedback.source, Tip) and feedback.type.name == "position"
        meaningful = {
            "free_axis": feedback.type.name == "orientation" or document.free_axis is None,
            "standoff": is_position or document.standoff is None,
            "funnel": is_position or document.funnel is None,
            "seek": isinstance(feedback.source, (FingerForces, NetForces)) or document.seek is None,
            "manipulator": document.potential == _MANIPULABILITY or document.manipulator is None,
        }
        for key, fits in meaningful.items():
            if not fits:
                place = self._context.source.key(*self._steps, key)
                self._context.add("CB513", place, name=key, feedback=feedback.type)
        # Only fingers flex.
        is_of_hands = isinstance(feedback.source, NetForces)
        if document.seek is not None and document.seek.until is not None and is_of_hands:
            place = self._context.source.key(*self._steps, "seek", "until")
            self._context.add("CB513", place, name="until", feedback=feedback.type)
        check_settings(
            feedback.type.name, self._context.source, self._steps, self._context.findings
        )

    def _settings(self, feedback: Resource) -> _Settings | None:
        """The controller's own settings, and the robot's for the rest."""
        body, source = self._context.body, self._context.source
        general = body.document.control.tasks.get(feedback.type.name)
        candidates: list[written.Controller | TaskSettings] = [self._document]
        if general is not None:
            candidates.append(general)
        gain = _first(settings.gain for settings in candidates)
        quiescence = _first(settings.quiescence for settings in candidates)
        if gain is None or quiescence is None:
            if not TYPES.keys() >= body.document.control.tasks.keys():
                return None  # one of them is misspelt, which has been reported
            lacking = {"a gain": gain, "a quiescence": quiescence}
            setting = " and ".join(name for name, value in lacking.items() if value is None)
            details = {"robot": body.document.name, "setting": setting}
            place = source.key(*self._steps)
            self._context.add("CB511", place, feedback=feedback.type, **details)
            return None
        return _Settings(
            gain,
            _first(settings.speed for settings in candidates),
            _first(settings.acceleration for settings in candidates),
            Quiescence(quiescence.rate, quiescence.window, quiescence.within, quiescence.tolerance),
        )


T = TypeVar("T")


def _first(values: Iterable[T | None]) -> T | None:
    """The first value that is set."""
    return next((value for value in values if value is not None), None)


def _spelled(chain: tuple[Cast, ...], feedback: Resource, effector: Resource) -> tuple[str, ...]:
    """Types and casts in turn, from the feedback's type to the effector's."""
    steps = [str(feedback.type)]
    for cast in chain:
        is_last = cast is chain[-1]
        steps += [str(cast), str(effector.type) if is_last else cast.target]
    return tuple(steps)


def _standoff(document: written.Standoff | None) -> Standoff | None:
    if document is None:
        return None
    return Standoff(document.clearance, document.least, document.most)


def _funnel(document: written.Funnel | None) -> Funnel | None:
    if document is None:
        return None
    return Funnel(document.height, document.within, document.slope)
