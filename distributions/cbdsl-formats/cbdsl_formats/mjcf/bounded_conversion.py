"""Conversion of MJCF in a process of its own, with bounded time and memory.

MuJoCo is native code, and a line of a model can request more memory than a machine has. Exceeding
the bounds ends the process, not the command.
"""

from __future__ import annotations

import base64
import json
import os
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from cbdsl.extend.model import ConvertedModel, PackageFolders, UrdfError, require_unmixed

_MOST_SECONDS = 10
# Time without computing, s: even on a busy machine, the process gets some of each second.
_MOST_IDLE_SECONDS = 5
_MOST_BYTES = 3_000_000_000
_BEGIN = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from cbdsl_formats.mjcf.bounded_conversion import main; main()"
)
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def convert_bounded(
    path: Path, name: str, arguments: Mapping[str, str], packages: PackageFolders
) -> ConvertedModel:
    """Return the URDF of an MJCF model; see ``convert_mjcf``.

    Args:
        path: Path of the model.
        name: Name of the robot.
        arguments: Unused; MJCF has none.
        packages: Unused; MuJoCo finds the files of a model.

    Raises:
        UrdfError: If the model is refused, or takes too much time or memory.
        UsageError: If files of MuJoCo are damaged.
        ModuleNotFoundError: If MuJoCo is not installed.
    """
    return _bounded("conversion:convert_mjcf", path, name)


def convert_scene_bounded(
    path: Path, name: str, arguments: Mapping[str, str], packages: PackageFolders
) -> ConvertedModel:
    """Return the stage of a scene, as ``convert_bounded`` returns a URDF; see ``convert_scene``."""
    return _bounded("scene:convert_scene", path, name)


def _bounded(function: str, path: Path, name: str) -> ConvertedModel:
    require_unmixed("mujoco")
    if find_spec("mujoco") is None:
        raise ModuleNotFoundError(name="mujoco")
    # The process imports from the same folders as this one. An empty entry is left out, because it
    # stands for the working folder, whose modules could shadow the library's.
    paths = json.dumps([folder for folder in sys.path if folder])
    command = [sys.executable, "-P", "-c", _BEGIN, paths, str(path), name, function]
    try:
        # The bound on processor time is set by the process itself. This longer one on elapsed time
        # allows for a busy machine. One thread per library saves address space, which is bounded,
        # too.
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=6 * _MOST_SECONDS,
            env={**os.environ, **_ONE_THREAD},
        )
        answer = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError):
        raise UrdfError(
            f"{path}: MuJoCo cannot compile it within {_MOST_SECONDS} s and "
            f"{_MOST_BYTES // 10**9} GB, or fails; does it replicate a part very often?"
        ) from None
    if "error" in answer:
        raise UrdfError(answer["error"])
    meshes = {file: base64.b64decode(text) for file, text in answer["meshes"].items()}
    return ConvertedModel(answer["text"], meshes, tuple(answer["remarks"]))


def main() -> None:
    """Convert the model that the command line names, and write it to standard output as JSON."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (_MOST_SECONDS, _MOST_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.dup(1)
    threading.Thread(target=_end_if_idle, args=(answers, sys.argv[2]), daemon=True).start()
    os.dup2(2, 1)  # warnings of native code must not mix with the answer
    answer: dict[str, object]
    try:
        module, _, function = sys.argv[4].partition(":")
        convert = getattr(import_module(f"cbdsl_formats.mjcf.{module}"), function)
        converted: ConvertedModel = convert(Path(sys.argv[2]), sys.argv[3])
        meshes = {file: base64.b64encode(data).decode() for file, data in converted.meshes.items()}
        answer = {"text": converted.text, "meshes": meshes, "remarks": converted.remarks}
    except UrdfError as error:
        answer = {"error": str(error)}
    with os.fdopen(answers, "w", encoding="utf-8") as stream:
        json.dump(answer, stream)


# MuJoCo opens the files that a model names in several ways, and waits for ever for a named pipe.
def _end_if_idle(answers: int, path: str) -> None:
    """End the process when it computes nothing, because it waits for a file."""
    idle = 0
    while idle < _MOST_IDLE_SECONDS:
        before = time.process_time()
        time.sleep(1.0)
        idle = idle + 1 if time.process_time() - before < 0.005 else 0
    reason = f"{path}: MuJoCo waits for a file that it names, such as a named pipe"
    os.write(answers, json.dumps({"error": reason}).encode())
    os._exit(0)
