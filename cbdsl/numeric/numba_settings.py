"""Settings of numba, of which none come from the current folder."""

from __future__ import annotations

import os
from contextlib import suppress


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
