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

#: Time for which a simulation waits for an output, s.
_LONGEST = 60.0
#: First outputs of which one must be in time.
_FIRST = 3


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
        self._seconds: list[float] = []

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

        A robot never waits. A simulation waits for each output, so that its result does not depend
        on the load of the computer. A network that no robot could follow is an error there.

        Args:
            deadline: Longest computation of an output in a simulation, s; 0 never waits.

        Raises:
            ValueError: All of the first outputs took more processor time than the deadline, or one
                took more than a minute.
        """
        request, self._request = self._request, None
        if request is None:
            return None
        try:
            output, seconds = request.result(_LONGEST if deadline else 0)
        except Late:
            # It stops at its next operator, and the next request waits until then.
            self._options.terminate = True
            if deadline:
                raise ValueError(f"an output takes more than {_LONGEST:g} s") from None
            self._request = request
            return None
        except Exception:  # of onnxruntime, for inputs that the dry run did not have
            return None
        if deadline:
            self._require_speed(seconds, deadline)
        return output if np.isfinite(output).all() else None

    def _require_speed(self, seconds: float, deadline: float) -> None:
        """Require that one of the first outputs took at most the deadline; a single one may stall.

        Raises:
            ValueError: None did.
        """
        if len(self._seconds) >= _FIRST:
            return
        self._seconds.append(seconds)
        quickest = min(self._seconds)
        if len(self._seconds) == _FIRST and quickest > deadline:
            raise ValueError(
                f"each of its first {_FIRST} outputs takes {1e3 * quickest:.0f} ms or more of "
                f"processor time, and its deadline is {1e3 * deadline:g} ms; raise the deadline, "
                "or use a smaller model"
            )

    def forget(self) -> None:
        """Forget the request of an earlier episode."""
        if self._request is not None:
            self._options.terminate = True
            self._request = None  # the next request follows it, and is not left out
        if isinstance(self._session, PolicySession):
            self._thread.submit(self._session.reset)
