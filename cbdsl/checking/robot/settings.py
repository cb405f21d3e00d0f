"""Units of settings whose dimension depends on the type of a feedback."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.types.unit import QuantityError, read_quantity
from cbdsl.yaml_text.source_map import SourceMap, Step

# Tasks have angular speeds, but positions have linear speeds, and poses have both.
_SPEEDS = {"position": ("speed",), "pose": ("speed", "angular speed")}
_ACCELERATIONS = {
    "position": ("acceleration",),
    "pose": ("acceleration", "angular acceleration"),
}
_TOLERANCES = {
    "position": ("length",),
    "pose": ("length", "angle"),
    "force": ("force",),
    "torque": ("torque",),
    "wrench": ("force", "torque"),
    "constellation": ("number",),
    "offset": ("length",),
}


def check_settings(
    kind: str,
    source: SourceMap,
    steps: tuple[Step, ...],
    findings: Findings,
    *,
    of_tips: bool = False,
) -> None:
    """Check the units of speed, acceleration and tolerance against a feedback's type.

    Args:
        kind: Name of the type.
        source: Source map of the document.
        steps: Path of the settings.
        findings: Diagnostics so far.
        of_tips: True if the speed of a force may be the speed of the tip that exerts it.
    """
    speeds = _SPEEDS.get(kind, ("angular speed",))
    allowed: dict[tuple[str, ...], tuple[str, ...]] = {
        ("speed",): (*speeds, "speed") if of_tips and kind == "force" else speeds,
        ("acceleration",): _ACCELERATIONS.get(kind, ("angular acceleration",)),
        ("quiescence", "tolerance"): _TOLERANCES.get(kind, ("angle",)),
        ("onset", "change"): _TOLERANCES.get(kind, ("angle",)),
        ("onset", "borne"): _TOLERANCES.get(kind, ("angle",)),
    }
    for keys, dimensions in allowed.items():
        path = (*steps, *keys)
        if not source.holds(*path):
            continue
        try:
            read_quantity(source.node(path).value, dimensions)
        except QuantityError as error:
            findings.add("CB506", source.place(*path), problem=str(error))
