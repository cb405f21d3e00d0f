"""Joint limits in the unit of the angle that is held against them."""

from __future__ import annotations

from cbdsl.types.unit import QuantityError, parse_quantity


def limit_details(written: object, angle: float, limits: tuple[float, float]) -> dict[str, str]:
    """Details of messages about an angle and the limits of its joint.

    Args:
        written: the angle in its document, whose unit is used; radians without one.
        angle: rad.
        limits: lower and upper, rad.
    """
    try:
        unit = parse_quantity(written)[1] if isinstance(written, str) else None
    except QuantityError:
        unit = None
    symbol, factor = ("rad", 1.0) if unit is None else (unit.symbol, unit.factor)
    numbers = {"angle": angle, "lower": limits[0], "upper": limits[1]}
    return {"unit": symbol} | {key: f"{value / factor:.4g}" for key, value in numbers.items()}
