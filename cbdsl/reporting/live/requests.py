"""The requests of a live page: what may be asked for, and how it is done."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from cbdsl.errors.nearest import suggestion
from cbdsl.reporting.live.server import RequestError
from cbdsl.reporting.live.transport import Transport

# Speeds beyond these are a slip, simulated seconds per second.
_SLOWEST, _FASTEST = 0.01, 100.0
_MOST_TICKS = 1000

Does = Callable[[Mapping[str, Any]], Mapping[str, Any]]


class Requests:
    """Answers to what pages ask for.

    Args:
        transport: of the run.
    """

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._does: dict[str, Does] = {
            "pause": self._pause,
            "continue": self._go_on,
            "step": self._step,
            "speed": self._hasten,
        }

    def __call__(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        """Do what is asked for.

        Raises:
            RequestError: it cannot be done.
        """
        name = request.get("do")
        if not isinstance(name, str) or name not in self._does:
            near, known = suggestion(str(name), self._does), ", ".join(self._does)
            raise RequestError(f"there is no request '{name}'{near} (known: {known})")
        return self._does[name](request)

    def _pause(self, _: Mapping[str, Any]) -> Mapping[str, Any]:
        self._transport.pause()
        return {}

    def _go_on(self, _: Mapping[str, Any]) -> Mapping[str, Any]:
        self._transport.go_on()
        return {}

    def _step(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
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


def number(request: Mapping[str, Any], key: str) -> float:
    """A finite number of a request.

    Raises:
        RequestError: it is none.
    """
    value = request.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise RequestError(f"{key}: {value!r} is no number")
    return float(value)
