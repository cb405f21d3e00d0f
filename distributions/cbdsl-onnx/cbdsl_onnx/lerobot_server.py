"""Server of a LeRobot policy, run by a Python that has lerobot; it imports nothing of cbdsl.

It reads requests from the standard input, one JSON object per line: ``{"reset": true}``, or arrays
by feature, each with its type, its shape, and its bytes in base 64. To the latter it answers
``{"action": [...], "seconds": s}`` with its processor time. The first line that it writes is
``{"ready": true}``, or ``{"fault": "..."}``.
"""

from __future__ import annotations

import base64
import json
import os
import sys
import time
from typing import Any


def loaded(folder: str) -> tuple[Any, Any, Any]:
    """Return a policy, and the functions that normalise observations and restore actions."""
    from lerobot.configs.policies import PreTrainedConfig
    from lerobot.policies import factory

    config = PreTrainedConfig.from_pretrained(folder)
    config.device = "cpu"
    policy = factory.get_policy_class(config.type).from_pretrained(folder, config=config)
    policy.eval()
    if not hasattr(factory, "make_pre_post_processors"):
        return policy, lambda batch: batch, lambda action: action  # it normalises by itself
    return policy, *factory.make_pre_post_processors(config, pretrained_path=folder)


def array(packed: dict[str, Any]) -> Any:
    """Return a packed array as a batch of one."""
    import numpy

    values = numpy.frombuffer(base64.b64decode(packed["data"]), packed["dtype"])
    return values.reshape(1, *packed["shape"])


def serve(folder: str, out: Any) -> None:
    """Answer requests until the standard input ends."""

    def write(answer: dict[str, Any]) -> None:
        out.write(json.dumps(answer) + "\n")
        out.flush()

    try:
        import torch

        policy, before, after = loaded(folder)
    except Exception as error:  # of any library of the other environment
        write({"fault": f"{type(error).__name__}: {error}"[:300]})
        return
    write({"ready": True})
    for line in sys.stdin:
        request = json.loads(line)
        if request.pop("reset", False):
            policy.reset()
            continue
        begun = time.process_time()
        try:
            with torch.no_grad():
                batch = {name: torch.tensor(array(each)) for name, each in request.items()}
                action = after(policy.select_action(before(batch)))
            answer = {"action": action.squeeze(0).tolist()}
        except Exception as error:
            answer = {"fault": f"{type(error).__name__}: {error}"[:300]}
        write({**answer, "seconds": time.process_time() - begun})


if __name__ == "__main__":
    answers = os.dup(1)
    os.dup2(2, 1)  # messages of libraries must not mix with the answers
    serve(sys.argv[1], os.fdopen(answers, "w"))
