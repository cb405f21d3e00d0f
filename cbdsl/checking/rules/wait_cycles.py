"""Controllers that wait for each other, so that none of them ever begins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.program.controller import Controller


class _Wait(NamedTuple):
    """Wait of a controller for another, by a key of the document."""

    waiting: str
    awaited: str
    steps: Steps


Waits = Mapping[str, list[_Wait]]


def check_waiting(context: ProgramContext, controllers: Iterable[tuple[str, Controller]]) -> None:
    """Report circles among the controllers that ``requires`` and ``seek: {once: ...}`` name.

    Args:
        context: Context of the program's document.
        controllers: Controllers of the program, with their keys in the document.
    """
    waits: dict[str, list[_Wait]] = {}
    for key, controller in controllers:
        for steps, awaited in _named(key, controller):
            waits.setdefault(controller.name, []).append(_Wait(controller.name, awaited, steps))
    # Circles of ``requires`` alone are reported first. The graph of all waits contains them again,
    # so that controllers that were reported are skipped.
    requires = {name: [w for w in own if w.steps[-1] == "requires"] for name, own in waits.items()}
    reported: set[str] = set()
    for code, verb, graph in (("CB585", "requires", requires), ("CB710", "waits for", waits)):
        for circle in _circles(graph):
            names = {wait.waiting for wait in circle}
            if reported.isdisjoint(names):
                _report(context, code, verb, circle)
                reported |= names


def _named(key: str, controller: Controller) -> Iterator[tuple[Steps, str]]:
    if controller.requires is not None:
        yield ("controllers", key, "requires"), controller.requires
    if controller.seek is not None and controller.seek.once is not None:
        yield ("controllers", key, "seek", "once"), controller.seek.once


def _circles(waits: Waits) -> Iterator[list[_Wait]]:
    """Yield the shortest way from each controller back to itself, if there is one."""
    for name in waits:
        if way := _way_back(name, waits):
            yield way


def _way_back(name: str, waits: Waits) -> list[_Wait] | None:
    # The search is breadth-first: the first way to a controller is a shortest one.
    ways: dict[str, list[_Wait]] = {name: []}
    ahead = [name]
    for each in ahead:  # the list grows
        for wait in waits.get(each, ()):
            way = [*ways[each], wait]
            if wait.awaited == name:
                return way
            if wait.awaited not in ways:
                ways[wait.awaited] = way
                ahead.append(wait.awaited)
    return None


def _report(context: ProgramContext, code: str, verb: str, circle: list[_Wait]) -> None:
    place: Callable[..., Place] = context.source.place
    first, *others = circle
    between = "".join(f"'{wait.waiting}', which {verb} " for wait in others)
    related = [(place(*w.steps), f"here '{w.waiting}' {verb} '{w.awaited}'") for w in others]
    details = {"name": first.waiting, "way": f"{between}{'it' if others else 'itself'}"}
    context.add(code, place(*first.steps), related=related, given="", **details)
