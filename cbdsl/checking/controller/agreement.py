"""Agreement between the parts of a controller, and identification of the part that disagrees."""

from __future__ import annotations

from cbdsl.checking.controller.comparison import Comparison, compare, compared_with
from cbdsl.checking.controller.controller_options import check_options, misplaced
from cbdsl.checking.controller.influence import is_measured, movers, moves
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.documents import program as written
from cbdsl.program.controller import Reference
from cbdsl.types.casts import FEATURES
from cbdsl.types.potential import POTENTIALS, PotentialType
from cbdsl.types.resource import Resource


# The feedback is the only part that all others depend on: potential, reference, effector and
# options. If one part does not suit it, this part is most likely the mistake. If several parts do
# not, the feedback is, and one diagnostic replaces theirs. The feedback may nevertheless suit all
# parts by its type, and the parts have faults of another kind. An example is a missing reference
# beside a speed in the wrong unit. Such faults are reported one by one.
class Agreement:
    """Check of the parts of one controller against its feedback.

    Each part that does not suit the feedback is a diagnostic. If several parts do not suit it, the
    only diagnostic is the feedback itself.

    Args:
        context: Program context.
        steps: Path of the controller.
        document: Controller section.
        potential: Potential.
        comparison: Reference, which is empty if the potential takes none.
        effector: Effector.

    Attributes:
        holds: True if all parts agree; set by the check.
    """

    def __init__(
        self,
        context: ProgramContext,
        steps: Steps,
        document: written.ControllerSection,
        potential: Outcome[PotentialType],
        comparison: Comparison,
        effector: Outcome[Resource],
    ) -> None:
        self._context, self._steps, self._document = context, steps, document
        self._potential, self._comparison, self._effector = potential, comparison, effector
        self.holds = False

    def check_without_feedback(self) -> None:
        """Check the parts that do not depend on the feedback, which is unknown."""
        self._wants_reference(self._context.diagnostics)

    def check(self, feedback: Resource) -> Reference | None:
        """Check all parts against the feedback.

        Returns:
            Reference, or ``None`` if it cannot be compared with the feedback.
        """
        if self._is_exchanged(feedback) or self._is_feature(feedback):
            return None
        context, document, effector = self._context, self._document, self._effector
        of = {part: Diagnostics() for part in ("potential", "reference", "effector", "options")}
        if isinstance(self._potential, Unknown) or self._accepts(
            self._potential, feedback, of["potential"]
        ):
            self._wants_reference(of["potential"])
        as_compared = compared_with(self._potential, feedback)
        compared = compare(context, self._steps, self._comparison, as_compared, of["reference"])
        reference = None if isinstance(compared, Unknown) else compared
        if not isinstance(effector, Unknown):
            self._moves(effector, feedback, of["effector"])
        check_options(context, self._steps, document, feedback, of["options"])
        self._conclude(feedback, of)
        wanted = not isinstance(self._potential, Unknown) and self._potential.reference
        self.holds &= wanted == (reference is not None)
        return reference

    def _conclude(self, feedback: Resource, of: dict[str, Diagnostics]) -> None:
        against = [part for part, diagnostics in of.items() if diagnostics.failed]
        self.holds = not against
        if self.holds:  # no part has warnings
            return
        suitable = self._suitable() if len(against) > 1 else []
        if len(against) < 2 or feedback.name in suitable:
            for diagnostics in of.values():
                self._context.diagnostics.extend(diagnostics.sorted())
            return
        related = [(each.place, each.message) for part in against for each in of[part].sorted()]
        details = {"feedback": feedback.type, "number": count(len(related), "part")}
        place = self._place("feedback")
        self._context.add(
            "CB530", place, names=suitable, related=related, name=feedback.name, **details
        )

    def _suitable(self) -> list[str]:
        """Return the signals that would agree with all other parts."""
        body = self._context.body
        known = (resource for resource in body.resources.values() if is_measured(resource))
        return [resource.name for resource in known if self._suits(resource)]

    def _suits(self, feedback: Resource) -> bool:
        effector = self._effector
        return (
            (isinstance(self._potential, Unknown) or accepts(self._potential, feedback))
            and self._comparison.suits(compared_with(self._potential, feedback))
            and (isinstance(effector, Unknown) or moves(self._context.body, effector, feedback))
            and not any(misplaced(self._document, feedback))
        )

    def _place(self, *steps: str) -> Place:
        return self._context.source.place(*self._steps, *steps)

    def _is_exchanged(self, feedback: Resource) -> bool:
        """Report an effector that is not movable if it seems to be exchanged with the feedback."""
        effector = self._effector
        if isinstance(effector, Unknown) or effector.movable or not is_measured(effector):
            return False
        if not (moves(self._context.body, feedback, effector) and self._comparison.suits(effector)):
            return False
        question = f"'{feedback.name}' moves it: are feedback and effector exchanged?"
        related = [(self._place("feedback"), question)]
        self._context.add("CB507", self._place("effector"), related=related, name=effector.name)
        return True

    def _is_feature(self, feedback: Resource) -> bool:
        """Report a feedback of a feature type, which has no cast to an effector's type."""
        why = FEATURES.get(feedback.type.name)
        if why is None:
            return False
        details = {"name": feedback.name, "feedback": feedback.type, "why": why}
        self._context.add("CB570", self._place("feedback"), names=self._suitable(), **details)
        return True

    def _accepts(
        self, potential: PotentialType, feedback: Resource, diagnostics: Diagnostics
    ) -> bool:
        if accepts(potential, feedback):
            return True
        times = f" x {potential.factors}" if (potential.factors or 1) > 1 else ""
        details = {
            "potential": potential.name,
            "feedback": feedback.type,
            "wanted": " or ".join(f"{kind}{times}" for kind in sorted(potential.accepts)),
        }
        if potential.reference == (self._document.reference is not None):
            related = [(self._place("potential"), "the potential")]
            place, names = self._place("feedback"), self._suitable()
            diagnostics.add(
                "CB503", place, names=names, related=related, name=feedback.name, **details
            )
            return False
        # If only one of potential and reference implies a reference, report the potential: the user
        # most likely meant another one.
        related = [(self._place("feedback"), f"the feedback, {feedback.type}")]
        place, names = self._place("potential"), self._potentials(feedback)
        given = {"given": potential.name, "name": feedback.name}
        diagnostics.add("CB503", place, names=names, related=related, **given, **details)
        return False

    def _potentials(self, feedback: Resource) -> list[str]:
        """Return the potentials for a feedback that take a reference if the document has one."""
        given = self._document.reference is not None
        known = (potential for potential in POTENTIALS.values() if potential.reference == given)
        return [potential.name for potential in known if accepts(potential, feedback)]

    def _wants_reference(self, diagnostics: Diagnostics) -> None:
        potential, given = self._potential, self._document.reference is not None
        if isinstance(potential, Unknown) or potential.reference == given:
            return
        if potential.reference:
            key = self._context.source.key(*self._steps)
            diagnostics.add("CB509", key, potential=potential.name)
        else:
            diagnostics.add("CB510", self._place("reference"), potential=potential.name)

    def _moves(self, effector: Resource, feedback: Resource, diagnostics: Diagnostics) -> None:
        """Check that the effector is movable and moves the feedback."""
        body = self._context.body
        if moves(body, effector, feedback):
            return
        place, names = self._place("effector"), movers(body, feedback)
        if not effector.movable:
            diagnostics.add("CB507", place, names=names, name=effector.name)
            return
        details = {"feedback": feedback.name, "why": "" if names else _why_nothing(feedback)}
        related = [(self._place("feedback"), f"the feedback, {feedback.type}")]
        reference = self._comparison.resource
        if reference is not None and reference.type == feedback.type and reference.movable:
            question = f"'{reference.name}' is measured: are reference and feedback exchanged?"
            related = [(self._place("reference"), question)]
        diagnostics.add("CB508", place, names=names, related=related, name=effector.name, **details)


def accepts(potential: PotentialType, feedback: Resource) -> bool:
    """Return whether a potential is a function of signals of a feedback's type."""
    factors = potential.factors or feedback.type.factors
    return feedback.type.name in potential.accepts and feedback.type.factors == factors


def _why_nothing(feedback: Resource) -> str:
    if not is_measured(feedback):
        return f"; no effector does, because it is not a signal ({feedback.origin.value})"
    return "; no effector does"
