"""Presentations: things of a context, their places, and the experimenter's actions on them."""

from __future__ import annotations

import math
from collections.abc import Collection
from graphlib import CycleError, TopologicalSorter

from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.stage.mesh_files import extents_of
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.documents.context import Context, PlaceSection, Presentation
from cbdsl.documents.form import BoxForm, ComposedForm, MeshForm, OpenBoxForm
from cbdsl.documents.stage import Fixture, StageDocument
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import Step

_FOR_THINGS = ("place", "motion", "removed_after", "returned_after")


def check_presentations(
    loaded: Loaded[StageDocument],
    diagnostics: Diagnostics,
    key: str,
    context: Context,
    body: Outcome[CheckedRobot],
) -> None:
    """Check all presentations of a context.

    Args:
        loaded: Stage.
        diagnostics: Diagnostics so far.
        key: Name of the context.
        context: Context of the stage.
        body: Robot of the stage.
    """
    for name, show in context.presentations.items():
        steps = ("contexts", key) if name is None else ("contexts", key, "placed", name)
        _PresentationCheck(loaded, diagnostics, steps, show, context).all(body)
    _circles(loaded, diagnostics, key, context)


def idle_keys(show: Presentation) -> list[str]:
    """Return the keys of a presentation that are about the thing that it shows."""
    return [key for key in _FOR_THINGS if getattr(show, key) is not None]


def _circles(
    loaded: Loaded[StageDocument], diagnostics: Diagnostics, key: str, context: Context
) -> None:
    """Report things that are placed on or beside each other in a circle."""
    before = {
        name: [each for each in placed.place.neighbours if each in context.placed]
        for name, placed in context.placed.items()
    }
    try:
        TopologicalSorter(before).prepare()
    except CycleError as error:
        circle = error.args[1]
        place = loaded.source.place("contexts", key, "placed", circle[-1], "place")
        diagnostics.add("CB360", place, circle=" -> ".join(reversed(circle)))


class _PresentationCheck:
    def __init__(
        self,
        loaded: Loaded[StageDocument],
        diagnostics: Diagnostics,
        steps: tuple[Step, ...],
        show: Presentation,
        context: Context,
    ) -> None:
        self._stage = loaded.document
        self._source = loaded.source
        self._diagnostics = diagnostics
        self._steps = steps
        self._show = show
        self._context = context

    def all(self, body: Outcome[CheckedRobot]) -> None:
        place = self._show.place
        for i, name in enumerate(self._show.things):
            things = self._source.declared(self._stage.things, "things")
            self._known(name, things, "thing of this stage", "things", i)
        if place is not None:
            self._neighbours(place)
        if not isinstance(body, Unknown) and place is not None and place.hand is not None:
            tips = [name for name, effector in body.document.effectors.items() if effector.tip]
            self._known(place.hand, tips, "effector with a tip", "place", "hand")
        self._complete()
        self._deeds()

    def _neighbours(self, place: PlaceSection) -> None:
        """Check that the object on or beside which a thing is placed exists."""
        if place.on is not None:
            self._neighbour(place.on, "on")
            self._on_fixture(place, place.on)
        if place.beside is not None:
            self._neighbour(place.beside.name, "beside", "name")

    def _neighbour(self, name: str, *steps: Step) -> None:
        fixtures = self._source.declared(self._stage.fixtures, "fixtures")
        placed = self._source.declared(self._context.placed, *self._steps[:2], "placed")
        if name not in placed:
            several = "fixture or placed thing of this context"
            what = several if self._context.placed else "fixture of this stage"
            self._known(name, fixtures, what, "place", *steps, besides=placed)

    def _on_fixture(self, place: PlaceSection, name: str) -> None:
        """Check that a thing on a fixture has its centre above it for all drawn places."""
        if place.hand is not None:
            self._lacks("place", "a place on a fixture is in the world, not in reach of a hand")
            return
        fixture = self._stage.fixtures.get(name)
        if fixture is None or place.beside is not None:
            return
        for axis, span, half in zip("xy", (place.x, place.y), _halves(fixture), strict=True):
            # Places on a drawn fixture are relative to its centre.
            centre = 0.0 if fixture.is_drawn else fixture.position["xy".index(axis)][0]
            # Values computed from centimetres may exceed an edge by a rounding error.
            beyond = [i for i, x in enumerate(span) if abs(x - centre) > half + 1e-9]
            if beyond:
                where = self._source.place(*self._steps, "place", axis, beyond[0])
                ends = {"first": f"{centre - half:.4g}", "last": f"{centre + half:.4g}"}
                details = {"axis": axis, "value": f"{span[beyond[0]]:.4g}", **ends}
                self._diagnostics.add("CB356", where, name=name, **details)

    def _known(
        self,
        name: str,
        names: Collection[str],
        what: str,
        *steps: Step,
        besides: Collection[str] = (),
    ) -> None:
        if name not in names:
            place = self._source.place(*self._steps, *steps)
            names = [*names, *besides]
            self._diagnostics.add("CB351", place, names=names, name=name, what=what)

    def _complete(self) -> None:
        """Check that keys about a thing come with a thing, and vice versa."""
        show, place = self._show, self._show.place
        if show.things and place is None:
            self._lacks("things", "things need a place")
        idle = idle_keys(show)
        if idle and not show.things:
            verb = "is" if len(idle) == 1 else "are"
            names = " and ".join(idle)
            self._lacks(idle[0], f"{names} {verb} for things, and this context has none")
        is_held = place is not None and place.held
        lacks_place = show.things and place is None
        if show.released_after is not None and not is_held and not lacks_place:
            self._lacks("released_after", "released_after needs a place with `held: true`")

    def _deeds(self) -> None:
        """Check that the experimenter's actions on a thing happen in a possible order."""
        show = self._show
        removed, released = show.removed_after, show.released_after
        is_held = show.place is not None and show.place.held
        if removed is not None and released is not None and removed <= released:
            self._excluded("removed_after", f"it is released only after {released:g} s")
        if show.motion is None:
            return
        start = show.motion.after[0]
        if is_held and (released is None or start < released):
            self._excluded("motion", "it is held still when the motion starts")
        if removed is not None and removed <= start:
            self._excluded("removed_after", "it is removed before its motion starts")

    def _excluded(self, key: str, problem: str) -> None:
        self._diagnostics.add("CB357", self._source.key(*self._steps, key), problem=problem)

    def _lacks(self, key: str, problem: str) -> None:
        self._diagnostics.add("CB353", self._source.key(*self._steps, key), problem=problem)


def _halves(fixture: Fixture) -> tuple[float, float]:
    """Return half the largest extent of a fixture along x and y, m."""
    form = fixture.form
    if isinstance(form, MeshForm):
        x, y, _ = extents_of(form) or (math.inf, math.inf, math.inf)
        return x / 2, y / 2
    if isinstance(form, (BoxForm, OpenBoxForm, ComposedForm)):
        return form.size[0][1] / 2, form.size[1][1] / 2
    return form.radius[1], form.radius[1]
