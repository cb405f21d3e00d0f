"""Zeros of load cells: weight and bias that they measure without contact."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cbdsl.documents.robot import Contact
from cbdsl.kinematics.forward import place_link
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Booleans, Floats, Integers
from cbdsl.numeric.compiled import compiled_once
from cbdsl.numeric.vector import copy

_GRAVITY = 9.81


class CellZeros:
    """Zeros of load cells: the wrenches that they measure without contact.

    The weight of the links that carry the cells comes from the model, as far as it has one. The
    bias is constant in a cell's frame except for its drift. It starts as the first measured wrench
    and follows the measurements while the cell is not in contact.

    Args:
        contact: Threshold of contact, and time constant of the bias.
        kinematics: Robot kinematics.
        links: Names of the links that carry the cells.
    """

    def __init__(self, contact: Contact, kinematics: Kinematics, links: Sequence[str]) -> None:
        self._threshold, self._tracking = contact.threshold, contact.zero_tracking
        self._kinematics = kinematics
        placed = [kinematics.link(link) for link in links]
        self._frames = np.array([link.frame for link in placed], dtype=np.int64)
        self._axes = np.array([link.rotation for link in placed]).reshape(len(links), 3, 3)
        bodies = [kinematics.inertial(link) for link in links]
        self._weights = np.array([_GRAVITY * body.mass if body else 0.0 for body in bodies])
        levers = [body.origin.xyz if body else (0.0, 0.0, 0.0) for body in bodies]
        self._levers = np.array(levers).reshape(len(links), 3)
        self._bias: Floats = np.zeros((len(links), 6))
        self.reset()

    def reset(self) -> None:
        """Treat the next wrenches as measured without contact."""
        self._time: float | None = None

    def remove(self, wrenches: Floats, time: float, loads: Floats, feeling: Booleans) -> bool:
        """Compute the loads, and the cells whose force exceeds the threshold.

        Args:
            wrenches: Measured wrenches in the kinematics' posture, N and N m, world frame, shape
                (cells, 6).
            time: Time of the measurement, s.
            loads: Output: wrenches without weight and bias, world frame, shape (cells, 6).
            feeling: Output: True for each cell whose force exceeds the threshold, shape (cells,).

        Returns:
            True if any cell is in contact.
        """
        is_first, elapsed, self._time = self._time is None, time - (self._time or 0.0), time
        share = 1.0 if is_first else -math.expm1(-elapsed / self._tracking)
        self._kinematics.place()
        return _remove(
            wrenches, self._kinematics.frames, self._frames, self._axes, self._weights,
            self._levers, self._threshold, share, is_first, self._bias, loads, feeling,
        )  # fmt: skip

    def resume(self, before: CellZeros) -> None:
        """Keep the biases of another episode and restart the clock."""
        self._bias, self._time = before._bias.copy(), 0.0


@compiled_once
def _remove(
    wrenches: Floats,
    frames: Floats,
    numbers: Integers,
    axes: Floats,
    weights: Floats,
    levers: Floats,
    threshold: float,
    share: float,
    is_first: bool,
    bias: Floats,
    loads: Floats,
    feeling: Booleans,
) -> bool:
    """Find loads and follow biases; see ``CellZeros``.

    Args:
        wrenches: Measured wrenches, shape (cells, 6).
        frames, numbers, axes: Frames of the model's joints, numbers of the frames that carry the
            cells, and the cells' axes there, as columns.
        weights: Weights of the links beyond the cells, N, shape (cells,).
        levers: Levers of these weights, in the cells' axes, m, shape (cells, 3).
        threshold: Contact threshold of the force, N.
        share: Share of a load below the threshold that is added to the bias.
        is_first: True if the whole load is bias, however large.
        bias: Biases in the cells' frames, shape (cells, 6); updated in place.
        loads, feeling: Outputs, as in ``CellZeros.remove``.
    """
    # Model: a cell at the rotation R measures w = load + weight + R b with a bias b. Below the
    # threshold of contact, b follows the rest of w with the time constant T:
    #     b <- b + (1 - exp(-dt / T)) R^T load.
    # A steady contact below the threshold is therefore absorbed by the bias.
    touching = False
    origin, turned = np.empty(3), np.empty((3, 3))
    for cell in range(len(loads)):
        place_link(frames[numbers[cell]], origin, axes[cell], origin, turned)
        load, own = loads[cell], bias[cell]
        copy(load, wrenches[cell], 1.0)
        _put_down(weights[cell], levers[cell], turned, load)
        if is_first:
            own[:] = 0.0
        _add_turned(turned, own, -1.0, load)
        feels = math.sqrt(load[0] ** 2 + load[1] ** 2 + load[2] ** 2) > threshold
        feeling[cell] = feels and not is_first
        if feeling[cell]:
            touching = True
            continue
        _add_turned(turned.T, load, share, own)
        if is_first:
            load[:] = 0.0
    return touching


@compiled_once
def _put_down(weight: float, lever: Floats, turned: Floats, load: Floats) -> None:
    """Subtract a weight, N, at a lever in the cell's axes, m, from the load that bears it."""
    x = turned[0, 0] * lever[0] + turned[0, 1] * lever[1] + turned[0, 2] * lever[2]
    y = turned[1, 0] * lever[0] + turned[1, 1] * lever[1] + turned[1, 2] * lever[2]
    load[2] -= weight
    load[3] -= y * weight
    load[4] += x * weight


@compiled_once
def _add_turned(turned: Floats, wrench: Floats, share: float, total: Floats) -> None:
    """Add a share of a wrench in other axes to a sum, shape (6,) each."""
    for i in range(3):
        for k in range(3):
            total[i] += share * turned[i, k] * wrench[k]
            total[3 + i] += share * turned[i, k] * wrench[3 + k]
