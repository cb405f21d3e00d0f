"""Joint limits in the unit of the compared position."""

from __future__ import annotations

from cbdsl.types.unit import UNITS, QuantityError, parse_quantity


def is_of_another_kind(written: object, unit: str) -> bool:
    """Return whether a position has the dimension of another kind of joint, such as m for rad."""
    try:
        given = parse_quantity(written)[1] if isinstance(written, str) else None
    except QuantityError:
        return False
    return given is not None and given.dimension != UNITS[unit].dimension


def limit_details(
    written: object, angle: float, limits: tuple[float, float], unit: str = "rad"
) -> dict[str, str]:
    """Return details of messages about a position and the limits of its joint.

    Args:
        written: Position as written in its document, whose unit is used if there is one.
        angle: Position, rad or m.
        limits: Lower and upper limit, rad or m.
        unit: Unit of the joint's position, used if the position has none.
    """
    try:
        given = parse_quantity(written)[1] if isinstance(written, str) else None
    except QuantityError:
        given = None
    symbol, factor = (unit, 1.0) if given is None else (given.symbol, given.factor)
    numbers = {"angle": angle, "lower": limits[0], "upper": limits[1]}
    return {"unit": symbol} | {key: f"{value / factor:.4g}" for key, value in numbers.items()}
