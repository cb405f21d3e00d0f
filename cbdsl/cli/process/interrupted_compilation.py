"""End of a command whose compilation was interrupted."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from traceback import walk_tb
from typing import NoReturn

_COMPILER = ("numba", "llvmlite")


# The compiler passes the ownership of modules to LLVM in two steps: a call of C, and a note in the
# Python object. An interrupt between the two leaves a module with two owners. The destructor of the
# object then frees it a second time, and the process ends by SIGABRT or SIGSEGV. The exception
# keeps the object alive as long as it is handled, so that the process has to end meanwhile.
def is_of_compiler(error: BaseException | None) -> bool:
    """Return whether an error, or an error that led to it, was raised within the compiler."""
    while error is not None:
        for frame, _ in walk_tb(error.__traceback__):
            if frame.f_globals.get("__name__", "").partition(".")[0] in _COMPILER:
                return True
        error = error.__cause__ or error.__context__
    return False


def leave(code: int) -> NoReturn:
    """End the process without the destructors of its objects."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)
