"""Tells that something is compiled, which would else look like a program that hangs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from numba.core import event

NOTICE = "compiling, once after each installation: up to a minute of processor time"


@contextmanager
def told_of_compilation() -> Iterator[None]:
    """Say so, once and on the standard error, as soon as a function is compiled.

    Functions that an earlier process compiled are only loaded, which takes no time.
    """
    with event.install_listener("numba:compile", _Teller()):
        yield


class _Teller(event.Listener):
    """Hears when the compiler begins and ends."""

    def __init__(self) -> None:
        self._announced = False

    def on_start(self, event: event.Event) -> None:
        """Tell of the first function."""
        if not self._announced:
            self._announced = True
            print(NOTICE, file=sys.stderr, flush=True)

    def on_end(self, event: event.Event) -> None:
        """The others follow at once."""
