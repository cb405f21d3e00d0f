"""Requests of a live page, and their execution."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from cbdsl.diagnostics.nearest import suggestion
from cbdsl.reporting.live.breakpoints import Breakpoints
from cbdsl.reporting.live.composed_program import Changes, ComposedProgram
from cbdsl.reporting.live.page_server import RequestError
from cbdsl.reporting.live.transport import IdleError, Transport
from cbdsl.runtime.program_composer import Composer, ComposerError

# Speeds beyond these are an input error, simulated seconds per second.
_SLOWEST, _FASTEST = 0.01, 100.0
_MOST_TICKS = 1000
_LARGEST = sys.float_info.max

Does = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class Requests:
    """Handler of the requests of pages.

    Args:
        transport: Transport of the run.
        composer: Composer of its program; ``None`` if manual changes are not allowed.
        save: Function that makes a document of the composed changes and a name.
        breakpoints: Breakpoints of the run.
        refused: Reasons for the refusal of requests, by name.
    """

    def __init__(
        self,
        transport: Transport,
        composer: Composer | None = None,
        save: Callable[[Changes, str], ComposedProgram] | None = None,
        breakpoints: Breakpoints | None = None,
        refused: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._transport, self._refused = transport, refused
        self._breakpoints = breakpoints or Breakpoints()
        self._does: dict[str, Does] = {
            "pause": self._pause,
            "continue": self._go_on,
            "step": self._step,
            "speed": self._hasten,
            "change": self._go_to_change,
            "break": self._choose_breakpoints,
            "back": self._go_back,
        }
        if composer is not None and save is not None:
            self._composer, self._save = composer, save
            self._does |= {
                "gain": self._set_gain,
                "hold": self._hold,
                "compose": self._compose,
                "save": self._make_document,
            }

    def __call__(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        """Execute a request.

        Raises:
            RequestError: The request cannot be executed.
        """
        name = request.get("do")
        if not isinstance(name, str) or name not in self._does:
            near, known = suggestion(str(name), self._does), ", ".join(self._does)
            raise RequestError(f"unknown request '{name}'{near} (known: {known})")
        if name in self._refused:
            raise RequestError(f"{name}: {self._refused[name]}")
        return self._does[name](request)

    def _pause(self, _: Mapping[str, Any]) -> Mapping[str, Any]:
        self._transport.pause()
        return {}

    def _go_on(self, _: Mapping[str, Any]) -> Mapping[str, Any]:
        self._transport.go_on()
        return {}

    def _step(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        # `isinstance` would accept true and false, which are integers in Python.
        ticks = request.get("ticks", 1)
        if type(ticks) is not int or not 1 <= ticks <= _MOST_TICKS:
            raise RequestError(f"ticks: {ticks!r} is not a whole number from 1 to {_MOST_TICKS}")
        self._transport.step(ticks)
        return {}

    def _hasten(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        given = request.get("value")
        speed = math.inf if given is None else number(request, "value")
        if given is not None and not _SLOWEST <= speed <= _FASTEST:
            raise RequestError(
                f"value: {given!r} is not from {_SLOWEST:g} to {_FASTEST:g}, or null"
            )
        self._transport.hasten(speed)
        return {}

    def _go_to_change(self, _: Mapping[str, Any]) -> Mapping[str, Any]:
        self._breakpoints.wait_for_change()
        self._transport.go_on()
        return {}

    def _choose_breakpoints(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        places: Any = request.get("at")
        if not _is_list_of(places, str):
            raise RequestError(f"at: {places!r} is not a list of steps and exits")
        try:
            self._breakpoints.choose(places)
        except ValueError as error:
            raise RequestError(f"at: {error}") from error
        return {"breakpoints": sorted(self._breakpoints.chosen)}

    def _go_back(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        time, now = number(request, "time"), self._transport.now
        if not 0.0 <= time <= now:
            raise RequestError(f"time: {time:g} s is not from 0 to {now:g} s, the time of the run")
        self._transport.go_back(time)
        return {}

    def _set_gain(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        name, gain = text(request, "controller"), number(request, "value")
        return {"gain": self._ask(lambda: self._composer.set_gain(name, gain))}

    def _hold(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        name, given = text(request, "controller"), request.get("target")
        target = None if given is None else numbers(request, "target")
        self._ask(lambda: self._composer.hold(name, target))
        return {}

    def _compose(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        stack = request.get("stack")
        if stack is not None and not _is_list_of(stack, str):
            raise RequestError(f"stack: {stack!r} is not a list of controllers, nor null")
        self._ask(lambda: self._composer.compose(stack))
        return {}

    def _make_document(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        composer, name = self._composer, text(request, "name")
        changes = Changes(dict(composer.gains), dict(composer.targets), composer.stack)
        try:
            made = self._save(changes, name)
        except ValueError as error:
            raise RequestError(str(error)) from error
        diagnostics = [f"{each.code} {each.message}" for each in made.diagnostics]
        return {"text": made.text, "findings": diagnostics, "left_out": list(made.left_out)}

    def _ask(self, change: Callable[[], Any]) -> Any:
        """Execute a change between two ticks."""
        try:
            return self._transport.ask(change)
        except (ComposerError, IdleError) as error:
            raise RequestError(str(error)) from error


def _is_list_of(value: object, kind: type) -> bool:
    return isinstance(value, list) and all(type(each) is kind for each in value)


def text(request: Mapping[str, Any], key: str) -> str:
    """Return a text of a request.

    Raises:
        RequestError: The value is no text.
    """
    value = request.get(key)
    if not isinstance(value, str):
        raise RequestError(f"{key}: {value!r} is not text")
    return value


def numbers(request: Mapping[str, Any], key: str) -> list[float]:
    """Return finite numbers of a request.

    Raises:
        RequestError: The value is no list of finite numbers.
    """
    values = request.get(key)
    if not isinstance(values, list):
        raise RequestError(f"{key}: {values!r} is not a list of numbers")
    return [number({key: value}, key) for value in values]


def number(request: Mapping[str, Any], key: str) -> float:
    """Return a finite number of a request.

    Raises:
        RequestError: The value is no finite number.
    """
    value: Any = request.get(key)
    # Whole numbers beyond the largest float have no finite value.
    is_number = type(value) is float or (type(value) is int and abs(value) <= _LARGEST)
    if not is_number or not math.isfinite(value):
        raise RequestError(f"{key}: {value!r} is not a number")
    return float(value)
