"""Tells that something is compiled, which would else look like a program that hangs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def told_of_compilation() -> Iterator[None]:
    """Say so, once and on the standard error, as soon as a function is compiled.

    Functions that an earlier process compiled are only loaded, which takes no time.
    """
    from numba.core import event

    class Teller(event.Listener):
        told = False

        def on_start(self, _: object) -> None:
            if not self.told:
                self.told = True
                print(NOTICE, file=sys.stderr, flush=True)

        def on_end(self, _: object) -> None:
            pass

    with event.install_listener("numba:compile", Teller()):
        yield


NOTICE = "compiling, once after each installation: some 15 s of processor time"
