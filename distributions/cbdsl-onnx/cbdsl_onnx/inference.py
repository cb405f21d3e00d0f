"""Inference outside of the tick: one request at a time, with a deadline."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import TimeoutError as Late
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.document import contents, digest_of_bytes
from cbdsl_onnx.model_file import load
from cbdsl_onnx.network import NetworkDocument
from cbdsl_onnx.plan import NetworkPlan


class Inference:
    """Session of a model in a thread of its own, without which the tick would wait.

    Args:
        plan: Checked network.

    Raises:
        ValueError: The model file has changed since it was checked.
    """

    def __init__(self, plan: NetworkPlan) -> None:
        data = contents(Path(plan.file), NetworkDocument.most_bytes)
        if digest_of_bytes(data) != plan.sha256:
            raise ValueError(f"{plan.file} has changed since it was checked")
        self._session, self._output = load(data), plan.output.name
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="network")
        self._request: Future[NDArray[Any]] | None = None
        self._begun = math.inf

    @property
    def is_busy(self) -> bool:
        """True while an output is not computed yet."""
        return self._request is not None and not self._request.done()

    def request(self, feeds: Mapping[str, NDArray[Any]]) -> None:
        """Begin to compute the output of inputs by name."""
        import onnxruntime

        self._options, self._begun = onnxruntime.RunOptions(), math.inf
        self._request = self._thread.submit(self._run, dict(feeds), self._options)

    def _run(self, feeds: dict[str, NDArray[Any]], options: Any) -> NDArray[Any]:
        self._begun = time.monotonic()
        return np.asarray(self._session.run([self._output], feeds, options)[0])

    def receive(self, deadline: float) -> NDArray[Any] | None:
        """Return the output of the last request, or ``None`` if it is late or not finite.

        Ticks of a simulation may be shorter than their simulated time, or starve the thread. An
        output is therefore late by the time of its own computation, and is waited for until then.

        Args:
            deadline: Longest computation of an output, s; 0 never waits.
        """
        request, self._request = self._request, None
        if request is None:
            return None
        try:
            elapsed = max(0.0, time.monotonic() - self._begun)  # 0 before the thread begins
            output = request.result(max(0.0, deadline - elapsed))
        except Late:
            # It stops at its next operator, and the next request waits until then.
            self._options.terminate = True
            self._request = request
            return None
        except Exception:  # of onnxruntime, for inputs that the dry run did not have
            return None
        return output if np.isfinite(output).all() else None

    def forget(self) -> None:
        """Forget the request of an earlier episode."""
        if self._request is not None:
            self._options.terminate = True
