"""Networks of tests: documents and models, written into a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from cbdsl_onnx import wire


def linear(weights: ArrayLike, bias: ArrayLike) -> bytes:
    """Return a model y = x W' + b of rows x.

    Args:
        weights: W, shape (outputs, components).
        bias: b, shape (outputs,).
    """
    w, b = np.atleast_2d(np.asarray(weights, "<f4")), np.asarray(bias, "<f4")
    outputs, size = w.shape
    nodes = [wire.node("MatMul", ("x", "w"), "h"), wire.node("Add", ("h", "b"), "y")]
    constants = [
        wire.tensor("w", (size, outputs), np.ascontiguousarray(w.T).tobytes()),
        wire.tensor("b", (outputs,), b.tobytes()),
    ]
    ends = wire.value_info("x", (1, size)), wire.value_info("y", (1, outputs))
    return wire.model(nodes, constants, ends[:1], ends[1:])


def write(folder: Path, name: str, model: bytes, **changes: Any) -> Path:
    """Write a network of Dexter's right arm into a folder; return the document's path.

    Args:
        folder: Folder.
        name: Name of the document and the model.
        model: Bytes of the model.
        changes: Keys that replace the document's.
    """
    document = {
        "cbdsl": 1,
        "kind": "network",
        "name": name,
        "robot": "dexter",
        "file": f"{name}.onnx",
        "inputs": {"x": {"of": ["right_arm.position"]}},
        "output": {"name": "y", "of": "right_arm.position", "gives": "displacement"},
        **changes,
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.onnx").write_bytes(model)
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


PROGRAM = """\
cbdsl: 1
kind: program
name: follow
robot: dexter
stage: absent
models: {net: moved}
controllers:
  start:
    {potential: spring, reference: [45 cm, -25 cm, 0 cm],
     feedback: right_arm.position, effector: right_arm.position}
  policy:
    {potential: learned, reference: right_arm.net,
     feedback: right_arm.position, effector: right_arm.position}
  keep_out:
    {potential: at_least, reference: -4 cm, axes: [z],
     feedback: right_arm.position, effector: right_arm.position}
  force:
    {potential: at_most, reference: [5 N, 5 N, 5 N],
     feedback: right_hand.net.force, effector: right_arm.position}
actions: [start, policy, keep_out, force, policy ◁ keep_out ◁ force]
policy:
  XXXX: start
  0XXX: start
  1XXX: policy ◁ keep_out ◁ force
  X***: policy ◁ keep_out ◁ force
limits: {transition_time: 3 s, reward_ends: false}
"""
