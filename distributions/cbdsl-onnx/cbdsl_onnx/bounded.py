"""Examination of a model in a process of its own, with bounded time and memory.

onnxruntime is native code. A small model can ask for more memory than a machine has, or compute for
hours in one operator. Exceeding the bounds ends the process, not the command.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from importlib.util import find_spec

from cbdsl_onnx.model_file import ModelFacts, ModelFileError, TensorFacts, examine

_MOST_SECONDS = 20
_MOST_BYTES = 4_000_000_000
# One thread per library saves address space, which is bounded, too.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_BEGIN = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from cbdsl_onnx.bounded import main; main()"
)


def examine_bounded(data: bytes) -> ModelFacts:
    """Return the facts of a model; see ``examine``.

    Raises:
        ModelFileError: The model cannot be used, or takes too much time or memory.
        ModuleNotFoundError: If onnxruntime is not installed.
    """
    if find_spec("onnxruntime") is None:
        raise ModuleNotFoundError(name="onnxruntime")
    # An empty entry is the working folder, whose modules could shadow the library's.
    paths = json.dumps([folder for folder in sys.path if folder])
    command = [sys.executable, "-P", "-c", _BEGIN, paths]
    try:
        # The process bounds its processor time; this longer bound allows for a busy machine.
        done = subprocess.run(
            command,
            input=data,
            capture_output=True,
            timeout=3 * _MOST_SECONDS,
            env={**os.environ, **_ONE_THREAD},
        )
        answer = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError):
        problem = f"it needs more than {_MOST_SECONDS} s or {_MOST_BYTES // 10**9} GB, or fails"
        raise ModelFileError("runtime", f"a dry run on zeros ends early: {problem}") from None
    if "fault" in answer:
        raise ModelFileError(answer["fault"], answer["reason"])
    return ModelFacts(*(_facts(answer[key]) for key in ModelFacts._fields))


def _facts(rows: dict[str, tuple[list[int], str]]) -> dict[str, TensorFacts]:
    return {name: TensorFacts(tuple(shape), dtype) for name, (shape, dtype) in rows.items()}


def main() -> None:
    """Examine the model of the standard input, and write its facts or its fault as JSON."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (_MOST_SECONDS, _MOST_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.dup(1)
    os.dup2(2, 1)  # warnings of native code must not mix with the answer
    answer: dict[str, object]
    try:
        answer = examine(sys.stdin.buffer.read())._asdict()
    except ModelFileError as error:
        answer = {"fault": error.fault, "reason": str(error)}
    with os.fdopen(answers, "w", encoding="utf-8") as out:
        out.write(json.dumps(answer))
