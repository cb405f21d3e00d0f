"""Models of the examples of diagnostics."""

from __future__ import annotations

import math
import struct

from cbdsl_onnx import wire


def scaled(*scale: float, kind: str = "Mul", opset: int = 17, external: bool = False) -> bytes:
    """Return a model ``y = x * scale`` of row vectors.

    Args:
        scale: Weights, one per component.
        kind: Operator between the two.
        opset: Version of the operators.
        external: True if the weights are said to be in another file.
    """
    size = len(scale)
    weights = wire.tensor("scale", (size,), struct.pack(f"<{size}f", *scale))
    if external:
        entry = wire.message((1, "location"), (2, "../../secret.bin"))
        weights = wire.message((1, size), (2, 1), (8, "scale"), (13, entry), (14, 1))
    ends = {name: [wire.value_info(name, (1, size))] for name in "xy"}
    product = wire.node(kind, ("x", "scale"), "y")
    return wire.model([product], [weights], ends["x"], ends["y"], opset)


#: Models by the names of their files.
EXAMPLES = {
    "example": scaled(1.0, 1.0, 1.0),
    "not_finite": scaled(1.0, math.nan, 1.0),
    "external": scaled(1.0, 1.0, 1.0, external=True),
    "unknown_operator": scaled(1.0, 1.0, 1.0, kind="Mull"),
    "text": b"weights",
}
