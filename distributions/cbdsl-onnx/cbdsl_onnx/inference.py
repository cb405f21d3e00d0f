"""Inference outside of the tick: one request at a time, with a deadline."""

from __future__ import annotations

import time
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import TimeoutError as Late
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.document import contents, digest_of_bytes
from cbdsl_onnx.lerobot_policy import PolicySession, digest_of_policy, is_policy
from cbdsl_onnx.model_file import load
from cbdsl_onnx.network import NetworkDocument
from cbdsl_onnx.plan import NetworkPlan

#: Time beyond the deadline for which a simulation waits for a thread that may starve, s.
_GRACE = 1.0


class Inference:
    """Session of a model in a thread of its own, without which the tick would wait.

    Args:
        plan: Checked network.

    Raises:
        ValueError: The model file has changed since it was checked.
    """

    def __init__(self, plan: NetworkPlan) -> None:
        file = Path(plan.file)
        data = contents(file, NetworkDocument.most_bytes)
        digest = digest_of_policy(file, data) if is_policy(file) else digest_of_bytes(data)
        if digest != plan.sha256:
            raise ValueError(f"{plan.file} has changed since it was checked")
        self._session = PolicySession(file) if is_policy(file) else load(data)
        self._output = plan.output.name
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="network")
        self._request: Future[tuple[NDArray[Any], float]] | None = None

    @property
    def is_busy(self) -> bool:
        """True while an output is not computed yet."""
        return self._request is not None and not self._request.done()

    def request(self, feeds: Mapping[str, NDArray[Any]]) -> None:
        """Begin to compute the output of inputs by name."""
        import onnxruntime

        self._options = onnxruntime.RunOptions()
        self._request = self._thread.submit(self._run, dict(feeds), self._options)

    def _run(self, feeds: dict[str, NDArray[Any]], options: Any) -> tuple[NDArray[Any], float]:
        """Return the output, and the processor time of its computation, s."""
        begun = time.thread_time()
        output = np.asarray(self._session.run([self._output], feeds, options)[0])
        return output, time.thread_time() - begun + getattr(self._session, "elsewhere", 0.0)

    def receive(self, deadline: float) -> NDArray[Any] | None:
        """Return the output of the last request, or ``None`` if it is late or not finite.

        Ticks of a simulation may be shorter than their simulated time, or starve the thread. An
        output is therefore late by the processor time of its own computation.

        Args:
            deadline: Longest computation of an output, s; 0 never waits.
        """
        request, self._request = self._request, None
        if request is None:
            return None
        try:
            output, seconds = request.result(deadline + _GRACE if deadline else 0)
        except Late:
            # It stops at its next operator, and the next request waits until then.
            self._options.terminate = True
            self._request = request
            return None
        except Exception:  # of onnxruntime, for inputs that the dry run did not have
            return None
        is_late = 0 < deadline < seconds
        return None if is_late or not np.isfinite(output).all() else output

    def forget(self) -> None:
        """Forget the request of an earlier episode."""
        if self._request is not None:
            self._options.terminate = True
        if isinstance(self._session, PolicySession):
            self._thread.submit(self._session.reset)
