"""Units of settings whose dimension depends on the type of a feedback."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.types.unit import QuantityError, read_quantity
from cbdsl.yaml_text.source_map import SourceMap, Step

# Joints move angularly; only positions are moved along, and poses both ways.
_SPEEDS = {"position": ("speed",), "pose": ("speed", "angular speed")}
_ACCELERATIONS = {
    "position": ("acceleration",),
    "pose": ("acceleration", "angular acceleration"),
}


def check_settings(
    kind: str, source: SourceMap, steps: tuple[Step, ...], findings: Findings
) -> None:
    """Check the units of ``speed`` and ``acceleration`` at a path against a feedback's type."""
    allowed = {
        "speed": _SPEEDS.get(kind, ("angular speed",)),
        "acceleration": _ACCELERATIONS.get(kind, ("angular acceleration",)),
    }
    for key, dimensions in allowed.items():
        if not source.holds(*steps, key):
            continue
        try:
            read_quantity(source.node((*steps, key)).value, dimensions)
        except QuantityError as error:
            findings.add("CB506", source.place(*steps, key), problem=str(error))
