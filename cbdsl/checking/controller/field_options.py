"""Field of a harmonic potential: its workspace, its grid and its obstacles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents import program as written
from cbdsl.program.controller import Ball, Box, Field, Literal, Reference
from cbdsl.types.potential import PotentialType
from cbdsl.types.relative import is_relative
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import configured, is_located
from cbdsl.types.unit import QuantityError, dimensions_of, read_quantity
from cbdsl.yaml_text.source_map import Step

# A grid of more than 160 vertices along each of three axes takes most of a gigabyte.
_MOST_VERTICES = 160**3
_MOST_DIMENSIONS = 3

Corner = tuple[float, ...]


class ControllerSpec(NamedTuple):
    """Parts of a controller that its field has to suit.

    Attributes:
        feedback: Signal that is kept away from the obstacles.
        reference: Goal of the feedback.
        joints: Effector's joints, whose limits bound the workspace by default.
    """

    feedback: Resource
    reference: Reference | None
    joints: tuple[str, ...]


def check_field(
    context: ProgramContext,
    steps: Steps,
    potential: PotentialType,
    field: written.FieldSection | None,
    spec: ControllerSpec,
) -> Outcome[Field | None]:
    """Check the field of one controller.

    Args:
        context: Program context.
        steps: Path of the controller.
        potential: Potential, which may need a field.
        field: Field section of the controller.
        spec: Other parts of the controller.

    Returns:
        Checked field, or ``None`` if there is none; unknown if it does not suit the controller.
    """
    source = context.source
    if field is None:
        if potential.field:
            context.add("CB520", source.key(*steps), potential=potential.name)
            return UNKNOWN
        return None
    steps = (*steps, "field")
    if not potential.field:
        context.add("CB521", source.key(*steps), potential=potential.name, setting="field")
        return UNKNOWN
    kind = spec.feedback.type
    if kind.name not in potential.accepts or kind.factors != potential.factors:
        return UNKNOWN
    if kind.size > _MOST_DIMENSIONS:
        details = {"name": spec.feedback.name, "size": count(kind.size, "dimension")}
        context.add("CB529", source.key(*steps), **details)
        return UNKNOWN
    return _Field(context, steps, field, spec).check()


class _Field:
    def __init__(
        self,
        context: ProgramContext,
        steps: Steps,
        field: written.FieldSection,
        spec: ControllerSpec,
    ) -> None:
        self._context = context
        self._steps = steps
        self._field = field
        self._wish = spec
        self._size = spec.feedback.type.size

    def check(self) -> Field:
        field = self._field
        self._units()
        bounds = self._bounds()
        obstacles = tuple(self._obstacles())
        if not isinstance(bounds, Unknown) and not self._has_room(*bounds):
            bounds = UNKNOWN
        if isinstance(self._wish.reference, Literal):
            self._goal(self._wish.reference.values, bounds, obstacles)
        return Field(
            field.lower, field.upper, field.spacing, field.scale, field.clearance, obstacles
        )

    def _add(self, code: str, *steps: Step, **details: object) -> None:
        place = self._context.source.place(*self._steps, *steps)
        self._context.add(code, place, **details)

    def _units(self) -> None:
        """Check that all quantities have the unit of the feedback, or of their component of it."""
        units = self._wish.feedback.type.units
        for steps in self._quantities():
            node = self._context.source.node((*self._steps, *steps))
            place = steps[-1]
            own = units[place : place + 1] if isinstance(place, int) else units
            dimensions = dict.fromkeys(
                each for unit in own or units for each in dimensions_of(unit)
            )
            try:
                # Sums of measures of a robot are lengths.
                is_sum = is_relative(node.value) and "$" not in str(node.value)
                read_quantity("0 m" if is_sum else node.value, tuple(dimensions))
            except QuantityError as error:
                self._add("CB506", *steps, problem=str(error))

    def _quantities(self) -> Iterator[tuple[Step, ...]]:
        """Yield the paths of the quantities that the text gives."""
        field, holds = self._field, self._context.source.holds
        corners: list[tuple[tuple[Step, ...], Corner | None]] = [
            (("lower",), field.lower),
            (("upper",), field.upper),
        ]
        single: list[tuple[Step, ...]] = [("spacing",), ("scale",), ("clearance",)]
        for i, obstacle in enumerate(field.obstacles):
            if not isinstance(obstacle, str):
                corners.append((("obstacles", i, "lower"), obstacle.lower))
                corners.append((("obstacles", i, "upper"), obstacle.upper))
                single.append(("obstacles", i, "radius"))
                single.append(("obstacles", i, "shaft"))
        yield from (path for path in single if holds(*self._steps, *path))
        for path, corner in corners:
            yield from ((*path, i) for i in range(len(corner or ())))

    def _bounds(self) -> Outcome[tuple[Corner, Corner]]:
        """Return the corners of the workspace."""
        lower, upper = self._field.lower, self._field.upper
        if lower is not None and upper is not None:
            return (lower, upper) if self._fit((), lower, upper) else UNKNOWN
        if lower is not None or upper is not None or not self._moves_between_limits():
            problem = f"a {self._wish.feedback.type.name} needs both lower and upper"
            self._add("CB524", problem=problem)
            return UNKNOWN
        model = self._context.body.model
        joints = [] if model is None else [model.joints.get(name) for name in self._wish.joints]
        known = [joint for joint in joints if joint is not None]
        if len(known) != self._size:
            return UNKNOWN  # the robot has faults
        endless = next((joint.name for joint in known if joint.endless), None)
        if endless is not None:
            problem = f"joint '{endless}' has no limits: the field needs both lower and upper"
            self._add("CB524", problem=problem)
            return UNKNOWN
        return tuple(joint.lower for joint in known), tuple(joint.upper for joint in known)

    def _moves_between_limits(self) -> bool:
        """Return whether the feedback is the effector's joints, so that their limits bound it."""
        own = configured(self._wish.feedback.source)
        return bool(own) and len(self._wish.joints) == self._size

    def _fit(self, steps: tuple[Step, ...], lower: Corner, upper: Corner) -> bool:
        """Return whether the corners of the workspace or a box have one number per component."""
        name, kind = self._wish.feedback.name, self._wish.feedback.type
        misfits = [
            (key, corner)
            for key, corner in (("lower", lower), ("upper", upper))
            if len(corner) != self._size
        ]
        for key, corner in misfits:
            numbers, wanted = count(len(corner), "number"), count(self._size, "component")
            problem = f"{numbers} given for '{name}', {kind}, which has {wanted}"
            self._add("CB524", *steps, key, problem=problem)
        return not misfits

    def _has_room(self, lower: Corner, upper: Corner) -> bool:
        """Return whether a grid has two cells along each axis; report it also if it is too fine."""
        spacing = self._field.spacing
        # A multiple of the spacing may be rounded down: 0.3 / 0.1 is less than 3. The outer
        # vertices of the grid are walls, so that two cells leave one free vertex between them.
        cells = [math.floor((b - a) / spacing + 1e-9) for a, b in zip(lower, upper, strict=True)]
        if min(cells) < 2:
            axis = cells.index(min(cells))
            problem = f"the workspace has less than two cells along axis {axis}; reduce the spacing"
            self._add("CB525", problem=problem)
        elif math.prod(n + 1 for n in cells) > _MOST_VERTICES:
            vertices = " x ".join(str(n + 1) for n in cells)
            self._add("CB526", "spacing", vertices=vertices)
        return min(cells) >= 2

    def _obstacles(self) -> Iterator[Box | Ball]:
        for i, obstacle in enumerate(self._field.obstacles):
            if isinstance(obstacle, str):
                ball = self._ball(obstacle, None, ("obstacles", i))
            elif obstacle.center is not None:
                ball = self._ball(obstacle.center, obstacle.radius, ("obstacles", i, "center"))
            else:
                yield from self._box(i, obstacle)
                continue
            if not isinstance(ball, Unknown):
                yield ball

    def _ball(self, text: str, radius: float | None, steps: tuple[Step, ...]) -> Outcome[Ball]:
        resource = self._context.resource(text, (*self._steps, *steps))
        if isinstance(resource, Unknown):
            return UNKNOWN
        feedback = self._wish.feedback
        if resource.type != feedback.type:
            kinds = {
                "kind": resource.type.apart_from(feedback.type),
                "feedback_type": feedback.type.apart_from(resource.type),
            }
            self._add("CB522", *steps, name=resource.name, feedback=feedback.name, **kinds)
        # Only a seen object has a radius that the robot measures.
        elif radius is None and not is_located(resource.source):
            self._add("CB523", *steps, name=resource.name)
        return Ball(resource, radius)

    def _box(self, i: int, obstacle: written.ObstacleSection) -> Iterator[Box]:
        lower, upper = obstacle.lower, obstacle.upper
        assert lower is not None
        assert upper is not None
        if not self._fit(("obstacles", i), lower, upper):
            return
        for axis, (a, b) in enumerate(zip(lower, upper, strict=True)):
            if a > b:
                problem = f"the box ends before it begins along axis {axis}; exchange its corners"
                self._add("CB525", "obstacles", i, problem=problem)
                return
        if obstacle.shaft is not None and self._size < 2:
            self._add("CB525", "obstacles", i, problem="a shaft needs two axes")
            return
        yield Box(f"box {i + 1} of the field", lower, upper, obstacle.shaft)

    def _goal(
        self,
        goal: Corner,
        bounds: Outcome[tuple[Corner, Corner]],
        obstacles: tuple[Box | Ball, ...],
    ) -> None:
        """Check that a constant goal is inside the workspace and clear of the boxes."""
        place = self._context.source.place(*self._steps[:-1], "reference")
        if not isinstance(bounds, Unknown) and len(goal) == self._size:
            lower, upper = bounds
            # Whole turns of joints without limits do not count.
            circular = self._context.body.circular(self._wish.feedback)
            goal = tuple(
                a + (x - a) % (2.0 * math.pi) if circular[i : i + 1] == (True,) else x
                for i, (a, x) in enumerate(zip(lower, goal, strict=True))
            )
            inside = [a < x < b for a, x, b in zip(lower, goal, upper, strict=True)]
            if not all(inside):
                self._context.add("CB527", place, axis=inside.index(False))
        for obstacle in obstacles:
            # A ball may move out of the way, and a shaft keeps the surroundings of the goal free.
            if not isinstance(obstacle, Box) or obstacle.shaft is not None:
                continue
            if _distance(goal, obstacle) <= self._field.clearance:
                self._context.add("CB528", place, name=obstacle.name)


def _distance(point: Corner, box: Box) -> float:
    beside = (max(a - x, x - b, 0.0) for a, x, b in zip(box.lower, point, box.upper, strict=True))
    return math.hypot(*beside)
