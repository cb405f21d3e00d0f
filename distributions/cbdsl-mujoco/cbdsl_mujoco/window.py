"""The simulator's own window."""

from __future__ import annotations

import os
import sys
from threading import Thread
from threading import enumerate as enumerate_threads
from typing import Any

from cbdsl.extend.backend import BackendError

# Longest time for a window to close, s.
_PATIENCE = 5.0


class Window:
    """MuJoCo's viewer, opened with the first state to show.

    Raises:
        BackendError: There is no screen, or a package for windows is missing.
    """

    def __init__(self) -> None:
        if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ):
            raise BackendError("the simulator's window needs a screen, but DISPLAY is not set")
        try:
            import mujoco.viewer
        except ImportError as error:
            raise BackendError(
                f"the simulator's window cannot be opened: {error}; try: pip install glfw"
            ) from error
        self._launch: Any = mujoco.viewer.launch_passive
        self._viewer: Any = None
        self._model: Any = None
        self._threads: list[Thread] = []

    def show(self, model: Any, data: Any) -> None:
        """Show the state; another model has another window."""
        if self._model is not model:
            self.close()
            others = set(enumerate_threads())
            self._viewer = self._launch(model, data, show_left_ui=False, show_right_ui=False)
            # The viewer starts threads, and offers no way to wait for them.
            self._threads = [each for each in enumerate_threads() if each not in others]
            self._model = model
        self._viewer.sync()

    def close(self) -> None:
        """Close the window and wait: a window that outlives the process makes it crash."""
        if self._viewer is not None:
            self._viewer.close()
            for thread in self._threads:
                thread.join(_PATIENCE)
            self._viewer = None
