"""Memory of an object's position, kept while a hand or another object occludes it."""

# Model: the position x of a ball on a level surface, with constant horizontal velocity v between
# images, observed with white noise. An alpha-beta filter estimates both:
#     x' = x + v T                       prediction over the period T
#     x = x' + alpha (z - x')            correction by the measured position z
#     v = v + beta / T (z - x')
# The gains of sighting n are those of a least-squares line, alpha = 2 (2 n - 1) / (n (n + 1)) and
# beta = 6 / (n (n + 1)), until they fall to the constant gains of the robot document. The centroid
# of a partly occluded region is biased. A measurement thus counts only if the size s = area
# (distance / focal length)^2 is near the largest size so far in every camera. If the share of one
# camera alone changes, an occluder arrives or leaves: beta is 0 for this image.
# Assumptions: objects do not change their size, and velocities are horizontal.
# Source: Kalata (1984) for alpha-beta filters; the rules of occlusion are additions of this
# project.

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from cbdsl.documents.robot import Regions
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.vision.association.association import look_alike

#: A line of sight leads to another object if its distance from the remembered position exceeds the
#: object's radius plus this, m.
BESIDE = 0.03

_STILL = np.zeros(3)
# Time for which displacements are kept, s; images must arrive with less delay.
_KEPT = 1.5
_SLACK = 1e-6
# Least visible share of an object in a camera, relative to the largest share in any camera.
_ALIKE = 0.9


class PositionMemory:
    """Filter of the triangulated position of one object, which holds it during occlusion.

    The centroid of a half-hidden region is not the centre of the object. A sighting therefore
    counts only if the apparent size, corrected for distance, is as large as the largest seen so far
    in every camera. An object is remembered as long as its absence is explained, such as by an
    occluding hand or a head turned away. Otherwise it is soon forgotten.

    Attributes:
        position: Position, m, world frame, shape (3,), or ``None`` while undefined.
        radius: Radius of a ball of the same apparent size, m; ``0`` while undefined.
        since: Time of discovery, s.
        last: Time, s, and place, m, world frame, shape (3,), of the last sighting before the object
            was forgotten; ``None`` before that.
    """

    def __init__(self, settings: Regions) -> None:
        self._settings = settings
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.position: Floats | None = None
        self.last: tuple[float, Floats] | None = None
        # Place of the last sighting, without the motion predicted since, m.
        self._place: Floats | None = None
        self.radius = 0.0
        self.rest()
        self.since = self._seen = self._shown = self._accounted = 0.0
        self._sightings = 0
        self._largest: Sequence[float] | None = None
        # Sizes at which each camera sees the same share of the object, m^2.
        self._visible: Sequence[float] | None = None
        # Sizes of the last accepted sighting, m^2.
        self._newest: Sequence[float] | None = None
        # Displacements of the last ticks, m, and the times at which they began, s.
        self._moves: deque[tuple[float, Floats]] = deque()
        self._time = 0.0

    @property
    def velocity(self) -> Floats | None:
        """Horizontal velocity, m/s, shape (3,), or ``None`` while undefined."""
        # A line through two points reflects their noise more than a motion.
        known = self.position is not None and self._sightings > 2
        return self._velocity.copy() if known else None

    @property
    def is_seen_whole(self) -> bool:
        """True if the newest images show the object as large as ever."""
        return self.position is not None and self._seen == self._shown

    @property
    def is_accounted_for(self) -> bool:
        """True if the newest images show the object, or its absence in them is explained."""
        return self._accounted == self._shown

    def has_shrunk(self, sizes: Sequence[float], aside: Sequence[float]) -> bool:
        """Return whether an object looks smaller than before, without a partial occlusion.

        The object is partly occluded in one camera if only its size shrinks there, and the other
        camera still sees it at its remembered position. An object that moved may have turned, but
        is seen whole, so that both cameras see similar sizes. The visible part beside a forearm
        does not look alike to both.

        Args:
            sizes: Apparent area times squared distance in each camera, m^2.
            aside: Distance of each line of sight from the remembered position, m.
        """
        if min(_shares(sizes, self._largest)) >= 1.0:
            return False
        shares = _shares(sizes, self._visible)
        if self._has_moved(shares, aside):
            return look_alike(sizes)
        return min(shares) >= _ALIKE * max(shares)

    def forget_size(self, sizes: Sequence[float], aside: Sequence[float]) -> None:
        """Let the next sighting set the size again, because no part of the object is occluded.

        The visible shares of the cameras relative to each other are kept if the object did not
        move, because a shoulder occludes it gradually.

        Args:
            sizes: Apparent sizes, as in ``has_shrunk``.
            aside: Distances, as in ``has_shrunk``.
        """
        shares = _shares(sizes, self._visible)
        self._largest = None
        if self._visible is None or self._has_moved(shares, aside):
            self._visible = None
        else:
            self._visible = [max(shares) * size for size in self._visible]

    def _has_moved(self, shares: Sequence[float], aside: Sequence[float]) -> bool:
        """Return whether the camera with the largest visible share sees the object elsewhere."""
        best = max(range(len(shares)), key=lambda camera: shares[camera])
        return self.position is None or aside[best] > BESIDE

    def see(self, time: float, position: Floats, sizes: Sequence[float]) -> bool:
        """Update the memory by a sighting; return whether it was accepted.

        Args:
            time: Time of the images, s.
            position: Triangulated position plus the displacement since the images, m, shape (3,).
            sizes: Apparent area times squared distance in each camera, m^2.
        """
        self._shown = time
        if look_alike(sizes) and not look_alike(self._largest or sizes):
            # The object was discovered half-hidden: size and place are those of a part.
            self._forget_part()
        largest, least = self._largest or sizes, self._settings.least_visible
        for size, most in zip(sizes, largest, strict=True):
            if size < least * most:
                return False
        shares = _shares(sizes, self._newest)
        # If one camera's visible share changes, an occluder arrives or leaves. The centroid then
        # shifts in that image, which does not indicate a motion.
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
        """Let the next sighting set size and place again; keep the time of discovery."""
        self._largest = self._visible = self._newest = None
        self._sightings = 0

    def predict(self, period: float, time: float) -> None:
        """Extrapolate a moving position by ``period`` seconds."""
        self._time = time
        if self.position is None or time - self._seen > self._settings.prediction:
            return
        if self._speed > self._settings.least_speed:
            self._move(time - period, self._velocity * period)

    def miss(self, time: float, *, explained: bool) -> None:
        """Handle a missing sighting; forget an object whose absence stays unexplained too long."""
        self._shown = time
        if explained:
            self._accounted = time
        elif time - self._accounted > self._settings.hold:
            if self.position is not None and self._place is not None:
                self.last = self._seen, self._place
            self.position = None

    def is_lost(self, time: float) -> bool:
        """Return whether an object that moved is unseen for longer than its motion is predicted."""
        moving = self._speed > self._settings.least_speed
        return moving and time - self._seen > self._settings.prediction

    def carry(self, displacement: Floats) -> None:
        """Displace the object with the hands that hold it, m, shape (3,)."""
        if self.position is not None:
            self._move(self._time, displacement)

    def moved_since(self, time: float) -> Floats:
        """Return the estimated displacement of the object since an image, m, shape (3,)."""
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
        """Set the velocity to zero, as when a hand has touched the object."""
        self._velocity, self._speed = _STILL, 0.0

    def _gains(self, sightings: int) -> tuple[float, float]:
        """Return the gains of the alpha-beta filter after a number of sightings.

        The first gains are those of a straight line fitted to all sightings, because the settled
        filter reacts too slowly to a motion.
        """
        settled = self._settings.gains
        together = sightings * (sightings + 1)
        fitted = 2 * (2 * sightings - 1) / together, 6 / together
        return max(settled[0], fitted[0]), max(settled[1], fitted[1])

    def _correct(self, time: float, position: Floats, *, steady: bool) -> None:
        """Correct the position by a sighting, and the velocity, too, by a steady one."""
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
    """Return sizes as shares of other sizes, 1 if there are no others."""
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
    """Correct a position, m, and a velocity, m/s, shape (3,) each; return the speed, m/s.

    Objects roll and slide on a level surface; a vertical velocity is a measurement error.

    Args:
        measured: Measured position.
        expected: Predicted position.
        velocity: Previous velocity.
        gains: Gains of position and velocity.
        period: Time since the previous measurement, s.
        position: Output: corrected position.
        level: Output: corrected velocity.
    """
    alpha, beta = gains
    for i in range(3):
        error = measured[i] - expected[i]
        position[i] = expected[i] + alpha * error
        level[i] = velocity[i] + beta * error / period if i < 2 else 0.0
    return math.sqrt(level[0] * level[0] + level[1] * level[1])
