"""The simulator's own window."""

from __future__ import annotations

import os
import sys
from typing import Any

from cbdsl.backends.backend import BackendError


class Window:
    """MuJoCo's viewer, opened when there is something to show.

    Raises:
        BackendError: there is no screen, or a package is missing that opens windows.
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

    def show(self, model: Any, data: Any) -> None:
        """Show the state; another model has another window."""
        if self._model is not model:
            self.close()
            self._viewer = self._launch(model, data, show_left_ui=False, show_right_ui=False)
            self._model = model
        self._viewer.sync()

    def close(self) -> None:
        """Close the window."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
