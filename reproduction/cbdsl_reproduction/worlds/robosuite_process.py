"""Process of robosuite in its own Python environment, and the requests to it."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from cbdsl.extend.backend import BackendError

#: Variable with the Python of robosuite's environment; else that of ``make robosuite``.
VARIABLE = "CB_ROBOSUITE"
_MADE = Path("build/robosuite/bin/python")
_WORKER = Path(__file__).with_name("robosuite_worker.py")


def robosuite_python() -> Path:
    """Return the Python of robosuite's environment.

    Raises:
        BackendError: There is none.
    """
    named = os.environ.get(VARIABLE)
    clone = Path(__file__).parents[3]
    for python in [Path(named)] if named else [_MADE, clone / _MADE]:
        if python.is_file():
            return python.absolute()
    looked = named or _MADE
    raise BackendError(
        f"no environment of robosuite at {looked}: `make robosuite` makes it in a clone, and "
        f"{VARIABLE} names its Python elsewhere"
    )


class RobosuiteProcess:
    """Process that simulates one task; see ``robosuite_worker.py`` for its requests.

    Args:
        task: Name of the environment of robosuite.
        arms: Names of the robots.
        rate: Control rate, Hz.
        cameras: Position and orientation of the cameras by name.
        view: Width and height of an image, px, and vertical angle of view, deg.

    Raises:
        BackendError: There is no environment of robosuite, or it cannot simulate the task.
    """

    def __init__(
        self,
        task: str,
        arms: Sequence[str],
        rate: float,
        cameras: Mapping[str, Mapping[str, list[float]]],
        view: tuple[int, int, float],
    ) -> None:
        python = robosuite_python()
        self._problems = tempfile.TemporaryFile("w+")  # noqa: SIM115 (closed by ``close``)
        environment = {"MUJOCO_GL": "egl", **os.environ}
        # Packages of this process are none of robosuite's.
        for name in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"):
            environment.pop(name, None)
        self._process = subprocess.Popen(
            [str(python), str(_WORKER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._problems,
            env=environment,
        )
        self._write({"task": task, "arms": arms, "rate": rate, "cameras": cameras, "view": view})

    def ask(self, do: str, **request: Any) -> tuple[dict[str, Any], bytes]:
        """Return the answer to a request, and the bytes of its images.

        Raises:
            BackendError: The process reports an error, or has ended.
        """
        assert self._process.stdout is not None
        self._write({"do": do, **request})
        line = self._process.stdout.readline()
        if not line:
            raise BackendError(f"robosuite has ended: {self._last_words()}")
        reply: dict[str, Any] = json.loads(line)
        if "error" in reply:
            raise BackendError(f"robosuite cannot {do}: {reply['error']}")
        return reply, self._process.stdout.read(reply["bytes"])

    def _write(self, request: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None
        # After its end, the process is reported when its answer is read.
        with suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()
        self._problems.close()

    def _last_words(self) -> str:
        self._problems.seek(0)
        lines = self._problems.read().strip().splitlines()
        return lines[-1] if lines else "without a message"
