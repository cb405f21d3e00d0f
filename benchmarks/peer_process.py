"""A peer in a process of its own, with the interpreter of another environment.

The process reads the scene, answers with its peers or with the reason why there are none, and then
times blocks of postures on demand. It exchanges one line of JSON a turn over its standard streams.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from peers import Scene, load

from cbdsl.numeric.arrays import Floats


class RemotePeer:
    """Peer that solves in another process.

    Attributes:
        name, solves: Name and objectives, as for any peer.
    """

    def __init__(self, process: subprocess.Popen[str], name: str, solves: str) -> None:
        self._process = process
        self.name, self.solves = name, solves

    def times(self, postures: Sequence[Floats]) -> list[float]:
        """Return times of a tick for each posture, us, by the other process's clock."""
        block = {"peer": self.name, "postures": [q.tolist() for q in postures]}
        times: list[float] = _ask(self._process, block)["times"]
        return times


@contextmanager
def remote_peers(module: str, python: str, scene: Scene) -> Iterator[list[RemotePeer]]:
    """Yield the peers of a library, in a process that ends with the context.

    Args:
        module: Name of the library's module.
        python: Interpreter of its environment.
        scene: Scene to solve.

    Raises:
        ImportError: The library cannot be imported there, or the process has died.
    """
    command = [python, str(Path(__file__)), module]
    pipe = subprocess.PIPE
    try:
        process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
    except OSError as error:
        raise ImportError(f"{python}: {error.strerror}") from error
    with process:
        told = _ask(process, {"urdf": str(scene.urdf), "ready": scene.ready.tolist()})
        if "missing" in told:
            raise ImportError(told["missing"])
        yield [RemotePeer(process, name, solves) for name, solves in told["peers"]]


def _ask(process: subprocess.Popen[str], message: dict[str, Any]) -> dict[str, Any]:
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(json.dumps(message) + "\n")
        process.stdin.flush()
    except BrokenPipeError:
        # The process has ended: it cannot answer, and closing would try to write once more.
        with suppress(BrokenPipeError):
            process.stdin.close()
    line = process.stdout.readline()
    if not line:
        raise ImportError(f"its process has ended with code {process.wait()}")
    answer: dict[str, Any] = json.loads(line)
    return answer


def serve(module: str) -> None:
    """Answer until the other side closes the pipe."""
    first = json.loads(sys.stdin.readline())
    try:
        peers = load(module, Scene(Path(first["urdf"]), np.array(first["ready"])))
    except ImportError as error:
        print(json.dumps({"missing": str(error)}), flush=True)
        return
    print(json.dumps({"peers": [(peer.name, peer.solves) for peer in peers]}), flush=True)
    by_name = {peer.name: peer for peer in peers}
    for line in sys.stdin:
        block = json.loads(line)
        times = by_name[block["peer"]].times([np.array(q) for q in block["postures"]])
        print(json.dumps({"times": times}), flush=True)


if __name__ == "__main__":
    serve(sys.argv[1])
