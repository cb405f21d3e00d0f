"""Motion of the arm of ``rclpy_cell.py``, which follows its references exactly."""

from __future__ import annotations


class CellMotion:
    """Joints that move straight to their newest reference.

    Args:
        positions: Start, rad.

    Attributes:
        positions: Positions at the newest time, rad.
    """

    def __init__(self, positions: list[float]) -> None:
        self.positions = list(positions)
        self._leg: tuple[float, float, list[float], list[float]] | None = None

    def follow(self, now: float) -> None:
        """Move until a time, s."""
        if self._leg is not None:
            begun, ends, first, last = self._leg
            share = min(1.0, max(0.0, (now - begun) / (ends - begun)))
            self.positions = [a + share * (b - a) for a, b in zip(first, last, strict=True)]

    def command(self, reference: list[float], now: float, begun: float, ends: float) -> None:
        """Move to a reference from where the joints are now, and not at the newest tick.

        Otherwise commands that come shortly before each tick would hold the joints still.

        Args:
            reference: Positions, rad.
            now: Time, s.
            begun: Time at which the motion begins, s; now if it is over.
            ends: Time at which the reference is reached, s, after now.
        """
        self.follow(now)
        self._leg = max(begun, now), ends, self.positions, list(reference)

    def stop(self) -> None:
        """Stay at the newest positions."""
        self._leg = None
