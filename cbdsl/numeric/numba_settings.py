"""Settings and imports of numba: none come from the current folder, and none are slow."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from types import ModuleType

# Module of which numba asks whether it can be imported, with its packages.
_BLAS = ("scipy", "scipy.linalg", "scipy.linalg.cython_blas")


def ignore_settings_of_folder() -> None:
    """Import numba without the settings in the current folder, which another author may have left.

    They could change results, or disable checks.
    """
    if not os.path.lexists(".numba_config.yaml"):
        return
    here = os.open(".", os.O_RDONLY | os.O_DIRECTORY)
    os.chdir("/")
    try:
        with suppress(ImportError):
            from numba.core import config

            config._config_fname = os.devnull  # numba reads it again before each compilation
    finally:
        os.fchdir(here)
        os.close(here)


@cache
def import_arrays_of_numba() -> None:
    """Import numba's functions of arrays, without scipy, which takes a sixth of a warm start.

    Numba imports scipy there only to learn whether it is installed. It imports it again, with a
    check of its binary interface, for each function that calls BLAS.
    """
    is_installed = find_spec("scipy") is not None
    absent = [name for name in _BLAS if is_installed and name not in sys.modules]
    sys.modules.update({name: ModuleType(name) for name in absent})
    try:
        import numba.np.arraymath  # noqa: F401 (for its effect)
    finally:
        for name in absent:
            del sys.modules[name]
