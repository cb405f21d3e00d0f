"""A remembered position: what stereo saw last, while a hand is in the way."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import Regions
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.association import look_alike

Floats = NDArray[np.float64]

#: A line of sight that passes where a thing is remembered by more than its radius and this leads to
#: something else, m.
BESIDE = 0.03

_STILL = np.zeros(3)
# How long displacements are kept, s: no image may be as late.
_KEPT = 1.5
_SLACK = 1e-6
# How much less a camera may see of a thing than the others do, compared with what they saw before.
_ALIKE = 0.9


class PositionMemory:
    """Filters the triangulated position of one thing and holds it while its region is hidden.

    The centroid of a half-hidden region is not the centre of the thing. A sighting therefore
    counts only while the region's apparent size, corrected for distance, is as large as the
    largest seen so far in every camera. A thing is remembered for as long as something explains
    why it is not seen, such as a hand that hides it or a head that looks elsewhere, and forgotten
    soon after otherwise.

    Attributes:
        position: m in the world frame, shape (3,), or ``None`` while undefined.
        radius: of a ball that would look as large, m; ``0`` while undefined.
        since: when it was discovered, s.
        last: when and where it was last, s and m in the world frame, shape (3,); ``None`` before it
            was seen.
    """

    def __init__(self, settings: Regions) -> None:
        self._settings = settings
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.position: Floats | None = None
        self.last: tuple[float, Floats] | None = None
        # Where it was seen last, without the motion that was predicted since, m.
        self._place: Floats | None = None
        self.radius = 0.0
        self.rest()
        self.since = self._seen = self._accounted = 0.0
        self._sightings = 0
        self._largest: Sequence[float] | None = None
        # Sizes with as much of the thing visible to each camera, m^2.
        self._visible: Sequence[float] | None = None
        # Sizes that were believed last, m^2.
        self._newest: Sequence[float] | None = None
        # Displacements of the last ticks, m, and when they began, s.
        self._moves: deque[tuple[float, Floats]] = deque()
        self._time = 0.0

    @property
    def velocity(self) -> Floats | None:
        """Velocity on the level, m/s, shape (3,), or ``None`` while undefined."""
        # A line through two points says more of their noise than of a motion.
        known = self.position is not None and self._sightings > 2
        return self._velocity.copy() if known else None

    def has_shrunk(self, sizes: Sequence[float], aside: Sequence[float]) -> bool:
        """Whether a thing is smaller than it looked before, unless something hides a part of it.

        What one camera alone sees less of, over a shoulder or past another thing, is hidden from
        that camera, if the other one sees it where it was. What has moved may have turned, but is
        seen whole, so that it looks alike to both: what is left of it beside a forearm does not.

        Args:
            sizes: apparent area times squared distance in each camera, m^2.
            aside: how far each line of sight passes where it is remembered, m.
        """
        if min(_shares(sizes, self._largest)) >= 1.0:
            return False
        shares = _shares(sizes, self._visible)
        if self._has_moved(shares, aside):
            return look_alike(sizes)
        return min(shares) >= _ALIKE * max(shares)

    def forget_size(self, sizes: Sequence[float], aside: Sequence[float]) -> None:
        """Let the next sighting set the size anew, since nothing hides any part of the thing.

        How much of it each camera saw, compared with the other one, is not forgotten of what stays
        where it is: a shoulder comes before it little by little.

        Args:
            sizes, aside: as ``has_shrunk`` has them.
        """
        shares = _shares(sizes, self._visible)
        self._largest = None
        if self._visible is None or self._has_moved(shares, aside):
            self._visible = None
        else:
            self._visible = [max(shares) * size for size in self._visible]

    def _has_moved(self, shares: Sequence[float], aside: Sequence[float]) -> bool:
        """Whether the camera that sees most of a thing sees it beside where it is remembered."""
        best = max(range(len(shares)), key=lambda camera: shares[camera])
        return self.position is None or aside[best] > BESIDE

    def see(self, time: float, position: Floats, sizes: Sequence[float]) -> bool:
        """Take in a sighting; returns whether it was believed.

        Args:
            time: s.
            position: triangulated, and displaced as since the images, m, shape (3,).
            sizes: apparent area times squared distance in each camera, m^2.
        """
        if look_alike(sizes) and not look_alike(self._largest or sizes):
            # It was met half-hidden: size and place are those of a part.
            self._forget_part()
        largest, least = self._largest or sizes, self._settings.least_visible
        for size, most in zip(sizes, largest, strict=True):
            if size < least * most:
                return False
        shares = _shares(sizes, self._newest)
        # Where one camera sees more or less of it than just before, something comes before it or
        # goes: then its middle moves in that image, and says nothing of a motion.
        steady = min(shares) >= least * max(shares)
        self._newest = list(sizes)
        self._largest = list(map(max, largest, sizes))
        self._visible = list(map(max, self._visible or sizes, sizes))
        self.radius = math.sqrt(sum(self._largest) / len(sizes) / math.pi)
        if self.position is None:
            self.since = time
        if not self._sightings or self.position is None:
            self.rest()
            self.position, self._sightings = position, 1
        else:
            self._correct(time, position, steady=steady)
        self._seen = self._accounted = time
        self._place = self.position
        return True

    def _forget_part(self) -> None:
        """Let the next sighting set size and place anew; when it was discovered stays."""
        self._largest = self._visible = self._newest = None
        self._sightings = 0

    def predict(self, period: float, time: float) -> None:
        """Carry a moving position on by ``period`` seconds."""
        self._time = time
        if self.position is None or time - self._seen > self._settings.prediction:
            return
        if self._speed > self._settings.least_speed:
            self._move(time - period, self._velocity * period)

    def miss(self, time: float, *, explained: bool) -> None:
        """Take in that there was no believable sighting, and whether something explains it."""
        if explained:
            self._accounted = time
        elif time - self._accounted > self._settings.hold:
            if self.position is not None and self._place is not None:
                self.last = self._seen, self._place
            self.position = None

    def is_lost(self, time: float) -> bool:
        """Whether the thing moved when it was last seen, for longer than that can be predicted."""
        moving = self._speed > self._settings.least_speed
        return moving and time - self._seen > self._settings.prediction

    def carry(self, displacement: Floats) -> None:
        """Take the thing to have moved with the hands that hold it, m, shape (3,)."""
        if self.position is not None:
            self._move(self._time, displacement)

    def moved_since(self, time: float) -> Floats:
        """How far the thing is taken to have moved since an image was taken, m, shape (3,)."""
        moves = self._moves
        while moves and moves[0][0] < time - _SLACK:
            moves.popleft()
        return sum([displacement for _, displacement in moves], _STILL)

    def _move(self, begun: float, displacement: Floats) -> None:
        assert self.position is not None
        self.position = self.position + displacement
        self._moves.append((begun, displacement))
        if self._moves[0][0] < begun - _KEPT:
            self._moves.popleft()

    def rest(self) -> None:
        """Take the thing to stand still, as when a hand has touched it."""
        self._velocity, self._speed = _STILL, 0.0

    def _gains(self, sightings: int) -> tuple[float, float]:
        """Gains of the alpha-beta filter: those of a straight line fitted to all sightings, as long
        as they are few; the settled filter takes too long to notice that a thing moves.
        """
        settled = self._settings.gains
        together = sightings * (sightings + 1)
        fitted = 2 * (2 * sightings - 1) / together, 6 / together
        return max(settled[0], fitted[0]), max(settled[1], fitted[1])

    def _correct(self, time: float, position: Floats, *, steady: bool) -> None:
        """Correct the position by a sighting, and the velocity, too, by one that is steady."""
        assert self.position is not None
        self._sightings += 1
        of_position, of_velocity = self._gains(self._sightings)
        gains = of_position, of_velocity if steady else 0.0
        period = max(time - self._seen, 1e-3)
        corrected, velocity = np.empty(3), np.empty(3)
        self._speed = _correct(
            position, self.position, self._velocity, gains, period, corrected, velocity
        )
        self.position, self._velocity = corrected, velocity


def _shares(sizes: Sequence[float], whole: Sequence[float] | None) -> list[float]:
    """Sizes as parts of others, 1 where there are no others."""
    return [size / most for size, most in zip(sizes, whole or sizes, strict=True)]


@compiled_once
def _correct(
    measured: Floats,
    expected: Floats,
    velocity: Floats,
    gains: tuple[float, float],
    period: float,
    position: Floats,
    level: Floats,
) -> float:
    """Correct an expected position and a velocity, m and m/s, shape (3,) each; returns the speed.

    Things roll and slide on something level; a vertical velocity is measurement error.

    Args:
        measured: position.
        expected: position.
        velocity: before.
        gains: of both.
        period: since the measurement before, s.
        position: becomes the corrected one.
        level: becomes the corrected velocity.
    """
    alpha, beta = gains
    for i in range(3):
        error = measured[i] - expected[i]
        position[i] = expected[i] + alpha * error
        level[i] = velocity[i] + beta * error / period if i < 2 else 0.0
    return math.sqrt(level[0] * level[0] + level[1] * level[1])
