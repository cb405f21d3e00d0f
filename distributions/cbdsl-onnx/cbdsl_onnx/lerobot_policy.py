"""Policies of LeRobot: a folder with ``config.json`` and ``model.safetensors``.

They run in a process of their own, by the Python that ``CB_LEROBOT`` names, since lerobot and torch
are no dependencies of cbdsl.
"""

from __future__ import annotations

import base64
import json
import os
import subprocess
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.document import contents, digest_of_bytes
from cbdsl_onnx import lerobot_server
from cbdsl_onnx.model_file import ModelFacts, ModelFileError, TensorFacts

#: Variable of the environment with the Python that has lerobot.
PYTHON = "CB_LEROBOT"
_CONFIG, _WEIGHTS = "config.json", "model.safetensors"
_MOST_CONFIG = 1_000_000
#: Longest load of a policy, s.
_LOADING = 120.0


def is_policy(file: Path) -> bool:
    """Return whether a model file is that of a LeRobot policy."""
    return file.name == _WEIGHTS


def digest_of_policy(file: Path, weights: bytes) -> str:
    """Return the digest of a policy: weights and configuration."""
    return digest_of_bytes(weights + contents(file.parent / _CONFIG, _MOST_CONFIG))


def examine_policy(file: Path) -> ModelFacts:
    """Return the features of a policy by its configuration.

    Raises:
        ModelFileError: It has no configuration, or no environment to run in.
    """
    try:
        config = json.loads(contents(file.parent / _CONFIG, _MOST_CONFIG))
        inputs = {name: _facts(each) for name, each in config["input_features"].items()}
        outputs = {name: _facts(each) for name, each in config["output_features"].items()}
    except OSError as error:
        reason = f"a LeRobot policy has a {_CONFIG} beside {_WEIGHTS}: {error.strerror}"
        raise ModelFileError("format", reason) from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ModelFileError("format", f"its {_CONFIG} lists no features of LeRobot") from None
    _python()
    return ModelFacts(inputs, outputs)


def _facts(feature: Mapping[str, Any]) -> TensorFacts:
    shape = tuple(int(size) for size in feature["shape"])
    return TensorFacts(shape, "float32")


def _python() -> str:
    """Return the Python that has lerobot.

    Raises:
        ModelFileError: The environment names none.
    """
    python = os.environ.get(PYTHON, "")
    if not os.access(python, os.X_OK):
        reason = f"it needs lerobot: set {PYTHON} to a Python that has it, such as env/bin/python"
        raise ModelFileError("runtime", reason)
    return python


class PolicySession:
    """Process of a policy, with the interface of a session of onnxruntime.

    Attributes:
        elsewhere: Processor time of the last output in that process, s.

    Args:
        file: Weights of the policy.

    Raises:
        ValueError: The process cannot load the policy; the message says why.
    """

    def __init__(self, file: Path) -> None:
        self.elsewhere = 0.0
        self._process = subprocess.Popen(
            [_python(), "-P", lerobot_server.__file__, str(file.parent)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        timer = threading.Timer(_LOADING, self._process.kill)
        timer.start()
        try:
            answer = self._answer()
        finally:
            timer.cancel()
        if "ready" not in answer:
            self.close()
            raise ValueError(f"the policy {file} cannot be loaded: {answer['fault']}")

    def run(
        self, names: Sequence[str], feeds: Mapping[str, NDArray[Any]], options: object
    ) -> list[NDArray[np.float64]]:
        """Return the next action of the policy, shape (m,).

        Raises:
            ValueError: The policy fails.
        """
        self._send({name: _packed(values) for name, values in feeds.items()})
        answer = self._answer()
        self.elsewhere = float(answer.get("seconds", 0.0))
        if "action" not in answer:
            raise ValueError(answer["fault"])
        return [np.array(answer["action"], dtype=float)]

    def reset(self) -> None:
        """Let the policy forget its queue of actions: an episode begins."""
        self._send({"reset": True})

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()

    def _send(self, request: dict[str, object]) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        answer: dict[str, Any] = json.loads(line) if line else {"fault": "its process has ended"}
        return answer


def _packed(values: NDArray[Any]) -> dict[str, object]:
    """Return an array as JSON can hold it: an image as a list of numbers would be slow."""
    data = base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()
    return {"dtype": str(values.dtype), "shape": values.shape, "data": data}
