"""Checks of a stage's scenes for overlaps with the robot and between objects.

Only overlaps independent of chance are reported. A drawn size counts as its smallest
value. Objects without a definite place are left to the drawing code.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import chain, combinations, product
from typing import Literal, NamedTuple

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.documents.context import Context, PlaceSection, Presentation
from cbdsl.documents.form import (
    BallForm,
    BoxForm,
    ComposedForm,
    Form,
    MeshForm,
    OpenBoxForm,
    TubeForm,
)
from cbdsl.documents.stage import Fixture, StageDocument
from cbdsl.robot.urdf import UrdfError, UrdfModel, UrdfOrigin, UrdfShape
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

Triple = tuple[float, float, float]
Rows = tuple[Triple, Triple, Triple]

_UNTURNED: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# Depth to which two bodies may each be inside the other, m.
_MARGIN = 1e-3


class _Solid(NamedTuple):
    """Ball, box or cylinder in the world; a cylinder lies along its z axis.

    Attributes:
        kind: Kind of the shape.
        halves: Half its extents along its own axes, m.
        position: Position of its centre, m.
        rotation: Rows of the matrix whose columns are its axes.
    """

    kind: Literal["ball", "box", "cylinder"]
    halves: Triple
    position: Triple
    rotation: Rows

    @property
    def reach(self) -> tuple[float, ...]:
        """Half the extents of a box along the world's axes that contains it, m."""
        if self.kind == "ball":
            return self.halves
        return tuple(
            sum(abs(part) * half for part, half in zip(row, self.halves, strict=True))
            for row in self.rotation
        )

    def overlaps(self, other: _Solid) -> bool:
        """Return whether the two share more than their surfaces."""
        # Boxes along the world's axes separate most pairs without arrays. Both solids shrink by the
        # margin, so that an object that rests on another does not overlap it.
        extents = zip(self.position, other.position, self.reach, other.reach, strict=True)
        if any(abs(p - q) >= a + b - 2 * _MARGIN for p, q, a, b in extents):
            return False
        # Few scenes have objects this close; import the array code for them alone.
        import numpy as np

        from cbdsl.numeric.convex import Convex, gap

        one, two = (
            Convex(each.kind, each.halves, np.array(each.position), np.array(each.rotation))
            for each in (self, other)
        )
        return gap(one.shrunk(_MARGIN), two.shrunk(_MARGIN)) == 0.0


def check_scenes(
    loaded: Loaded[StageDocument], body: Outcome[CheckedRobot], diagnostics: Diagnostics
) -> None:
    """Check that the objects in the scenes of a stage do not overlap."""
    stage = loaded.document
    fixtures = {
        name: _Solid(*_smallest(fixture.form), _middle(fixture), _UNTURNED)
        for name, fixture in stage.fixtures.items()
        if not fixture.is_drawn and not _is_hollow(fixture.form)
    }
    if not isinstance(body, Unknown) and body.model is not None:
        _in_robot(loaded, body, body.model, fixtures, diagnostics)
    for key, context in stage.contexts.items():
        _in_each_other(loaded, key, context, fixtures, diagnostics)


def _in_robot(
    loaded: Loaded[StageDocument],
    body: CheckedRobot,
    model: UrdfModel,
    fixtures: Mapping[str, _Solid],
    diagnostics: Diagnostics,
) -> None:
    """Report fixtures that overlap the robot's base."""
    if not fixtures:
        return
    try:
        base = _base(model)
    except UrdfError:  # reported by the code that needs the shapes
        return
    for name, fixture in fixtures.items():
        link = next((link for link, solid in base if fixture.overlaps(solid)), None)
        if link is not None:
            place = loaded.source.place("fixtures", name, "position")
            robot = body.document.name
            diagnostics.add("CB363", place, name=name, link=link, robot=robot)


def _in_each_other(
    loaded: Loaded[StageDocument],
    key: str,
    context: Context,
    fixtures: Mapping[str, _Solid],
    diagnostics: Diagnostics,
) -> None:
    """Report things that overlap other things or fixtures."""
    arrangement = _Arrangement(loaded.document, context, fixtures)
    things = list(arrangement.things())
    pairs = chain(combinations(things, 2), product(things, fixtures.items()))
    for (name, solid), (other, obstacle) in pairs:
        if solid.overlaps(obstacle):
            steps: tuple[Step, ...] = ("contexts", key)
            if name is not None:
                steps = (*steps, "placed", name)
            place = loaded.source.place(*steps, "place")
            shown = "this thing" if name is None else f"'{name}'"
            diagnostics.add("CB362", place, name=shown, other=other)


class _Arrangement:
    """Things of a context that have a definite place.

    Args:
        stage: Stage with the things.
        context: Context of the stage.
        fixtures: Fixtures that have a definite place, by name.
    """

    def __init__(
        self, stage: StageDocument, context: Context, fixtures: Mapping[str, _Solid]
    ) -> None:
        self._stage, self._shows, self._fixtures = stage, context.presentations, fixtures
        self._known: dict[str | None, _Solid | None] = {}

    def things(self) -> Iterator[tuple[str | None, _Solid]]:
        """Yield all solid things with their names."""
        for name in self._shows:
            solid = self._thing(name)
            if solid is not None:
                yield name, solid

    def _thing(self, name: str | None) -> _Solid | None:
        if name not in self._known:
            self._known[name] = None  # for things that are placed in a circle
            show = self._shows.get(name)
            self._known[name] = None if show is None else self._placed(show)
        return self._known[name]

    def _placed(self, show: Presentation) -> _Solid | None:
        forms = [
            self._stage.things[name].form for name in show.things if name in self._stage.things
        ]
        place = show.place
        # The thing has to have one filled shape and to stand upright.
        if (
            len(forms) != 1
            or _is_hollow(forms[0])
            or place is None
            or place.hand is not None
            or place.pitch != (0, 0)
        ):
            return None
        kind, halves = _smallest(forms[0])
        where, turned = self._where(place, halves[2]), place.yaw
        if where is None:
            return None
        if turned[0] != turned[1] and kind == "box":
            # This cylinder is part of the box at any angle about z.
            across = min(halves[0], halves[1])
            return _Solid("cylinder", (across, across, halves[2]), where, _UNTURNED)
        c, s = math.cos(turned[0]), math.sin(turned[0])
        return _Solid(kind, halves, where, ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))

    def _where(self, place: PlaceSection, half_height: float) -> Triple | None:
        """Return the position of the thing's centre if it is definite, else ``None``."""
        across = self._across(place)
        if across is None:
            return None
        x, y = across
        if place.z is not None:
            return (x, y, place.z[0]) if place.z[0] == place.z[1] else None
        level = place.on or (place.beside.name if place.beside is not None else "")
        other = self._fixtures.get(level) or self._thing(level)
        if other is None:
            return None
        # Solids stand upright here, so that the third half extent is vertical. An object beside
        # another has its lower side at the same height.
        if place.on is None:
            return x, y, other.position[2] - other.halves[2] + half_height
        return x, y, other.position[2] + other.halves[2] + half_height

    def _across(self, place: PlaceSection) -> tuple[float, float] | None:
        if place.beside is None:
            definite = place.x[0] == place.x[1] and place.y[0] == place.y[1]
            # On another thing, x and y are in the frame of that thing, which may be turned.
            in_world = place.on is None or place.on in self._fixtures
            return (place.x[0], place.y[0]) if definite and in_world else None
        other = self._fixtures.get(place.beside.name) or self._thing(place.beside.name)
        (by, most), (direction, last) = place.beside.by, place.beside.direction
        if other is None or by != most or direction != last:
            return None
        x, y, _ = other.position
        return x + by * math.cos(direction), y + by * math.sin(direction)


def _is_hollow(form: Form) -> bool:
    return isinstance(form, (OpenBoxForm, TubeForm, ComposedForm, MeshForm))


def _smallest(form: Form) -> tuple[Literal["ball", "box", "cylinder"], Triple]:
    """Return the shape, and half the extents of the smallest one that may be drawn, m."""
    if isinstance(form, (BoxForm, OpenBoxForm, ComposedForm)):
        a, b, c = (least / 2 for least, _ in form.size)
        return "box", (a, b, c)
    assert not isinstance(form, MeshForm), "like what is hollow, it has no one shape"
    radius = form.radius[0]
    if isinstance(form, BallForm):
        return "ball", (radius, radius, radius)
    return "cylinder", (radius, radius, form.height[0] / 2)


def _middle(fixture: Fixture) -> Triple:
    (x, _), (y, _), (z, _) = fixture.position
    return x, y, z


@lru_cache(maxsize=8)  # most stages are for one robot
def _base(model: UrdfModel) -> tuple[tuple[str, _Solid], ...]:
    """Return the solids of the links that no joint moves, with the links' names."""
    return tuple((link, solid) for link in _unmoved(model) for solid in _solids(model, link))


def _unmoved(model: UrdfModel) -> Iterator[str]:
    """Yield the links that no joint moves."""
    for link in model.bodies:
        if all(joint.fixed for joint in model.way(link)):
            yield link


def _solids(model: UrdfModel, link: str) -> Iterator[_Solid]:
    """Yield the balls, boxes and cylinders of a link that no joint moves."""
    position, rotation = (0.0, 0.0, 0.0), _UNTURNED
    for joint in reversed(model.way(link)):
        position, rotation = _within(position, rotation, joint.origin)
    for shape in model.bodies[link].collisions:
        size = _halves(shape)
        if size is not None:
            yield _Solid(*size, *_within(position, rotation, shape.origin))


def _halves(shape: UrdfShape) -> tuple[Literal["ball", "box", "cylinder"], Triple] | None:
    match shape.kind, shape.size:
        case "ball", (radius,):
            return "ball", (radius, radius, radius)
        case "box", (x, y, z):
            return "box", (x / 2, y / 2, z / 2)
        case "cylinder", (radius, height):
            return "cylinder", (radius, radius, height / 2)
    return None


def _within(position: Triple, rotation: Rows, origin: UrdfOrigin) -> tuple[Triple, Rows]:
    """Return the pose in the world of a frame that is given in another one."""
    columns = tuple(zip(*origin.rotation, strict=True))
    x, y, z = (at + _dot(row, origin.xyz) for at, row in zip(position, rotation, strict=True))
    a, b, c = (
        (_dot(row, columns[0]), _dot(row, columns[1]), _dot(row, columns[2])) for row in rotation
    )
    return (x, y, z), (a, b, c)


def _dot(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    return sum(a * b for a, b in zip(one, other, strict=True))
