"""Causes that keep a level from its target.

Model. Let e be the error of a level, J its rows, and p = J' e the pull on the joints, along which
e' e falls. Where the level gets no nearer, others balance its pull (Karush, Kuhn and Tucker):

    p = A' lambda + sum_j mu_j n_j,   mu_j >= 0

with the rows A of the levels above, and the outward normals n_j of joints at their limits. A level
or the limits hold it if the balance fails without them. If p vanishes by itself, the error is at
right angles to all motions of the level: the posture is singular. Then the curvature

    J' J - sum_i e_i H_i + sum_j lambda_j H_j

with the Hessians H is positive at a local optimum and negative along a direction at a saddle. The
law's bound decides which values are none. The curvature also gives the gain that a level at rest by
its criterion still has nearby. Assumption: errors are small turns or plain differences, so that
their slope is constant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cbdsl.control.law import Step
from cbdsl.control.second_order import RESISTED
from cbdsl.diagnostics.counting import some
from cbdsl.numeric.arrays import Floats

#: Holder of a level whose freedom is taken by joints at their limits.
LIMITS = "joint limits"
#: The same of links that keep a clearance.
CLEARANCE = "clearance"

#: Causes of a level whose pull vanishes.
OPTIMUM, SINGULAR = "local optimum", "singular posture"

#: Cause of a level that levels above hold, and causes at the end of an episode.
HELD, OUT_OF_REACH, BLOCKED, CREEPING = "held", "out of reach", "blocked", "creeping"

# Holders whose rows are outward normals, which balance a pull along them alone.
_SIDED = LIMITS, CLEARANCE

# Share of the largest pull of such an error below which there is none.
_NO_PULL = 0.03
# Share of the squared pull above which a holder counts.
_TAKEN = 0.1
# Share of the squared error by which a level that is stuck can still improve nearby, and how near,
# rad or m.
_GAIN, _NEARBY = 0.02, 0.05
# Displacement of a task in a tick, in its unit, that is rounding.
_ROUNDING = 1e-9


class RestCause(NamedTuple):
    """Cause that keeps a level from its target.

    Attributes:
        kind: ``LIMITS``, ``HELD``, ``OPTIMUM``, ``SINGULAR``, ``OUT_OF_REACH``, ``BLOCKED`` or
            ``CREEPING``.
        holders: Levels above, or ``LIMITS``, that hold it, the largest part first.
        joints: Joints at limits that hold it, or that do not follow their references.
        least: Least error found in any posture, in the unit of the feedback; NaN without a search.
        pairs: Pairs of links whose distance holds it.
        obstructions: Weights and contacts of links that keep these joints back.
    """

    kind: str
    holders: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    least: float = math.nan
    pairs: tuple[str, ...] = ()
    obstructions: tuple[str, ...] = ()

    @property
    def holder(self) -> str:
        """The largest holder, or the cause of a level without one; empty if it moves."""
        return self.holders[0] if self.holders else "" if self.kind == CREEPING else self.kind

    def __str__(self) -> str:
        if self.kind == BLOCKED:
            reasons = f" ({'; '.join(self.obstructions)})" if self.obstructions else ""
            return f"{BLOCKED} at {enumerated(self.joints)}{reasons}"
        return f"held by {' and '.join(self.words)}" if self.kind == HELD else self.kind

    @property
    def words(self) -> list[str]:
        """Holders, with the pairs of links in place of their clearance."""
        clear = f"the clearance of {some(self.pairs, 1)}"
        return [clear if holder == CLEARANCE else holder for holder in self.holders]


def enumerated(names: Sequence[str]) -> str:
    """Return names as a list in words, such as "a, b and c"."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


class Balance(NamedTuple):
    """Joints and names of the levels of a step.

    Attributes:
        step: Step of the law.
        names: Names of its levels, highest priority first.
        joints: Names of its n joints.
        outward: 1 for a joint at its upper limit, -1 at its lower one, else 0, shape (n,).
        apart: Decrease of the distance per joint, shape (n,), by pairs of links that keep it.
    """

    step: Step
    names: Sequence[str]
    joints: Sequence[str]
    outward: Floats
    apart: Mapping[str, Floats] = MappingProxyType({})

    def cause(self, place: int) -> RestCause | None:
        """Return the cause that keeps a level from its target; ``None`` if nothing does."""
        stack = self.step.stack
        wanted = stack.split(stack.requested)[place]
        requested = float(np.linalg.norm(wanted))
        if requested <= _ROUNDING:
            return None
        rows = stack.split(stack.acting_rows)
        own, above = rows[place], rows[:place]
        number = int(np.flatnonzero(stack.ages)[place])
        length = float(stack.arrays.errors[number])
        if not length > 0.0:  # a controller that searches has no error
            length = requested / float(stack.arrays.fractions[number])
        error = length * wanted / requested
        pull = own.T @ error
        holders = dict(zip(self.names, above, strict=False))
        if self.outward.any():
            holders[LIMITS] = np.diag(self.outward)[self.outward != 0.0]
        if self.apart:
            holders[CLEARANCE] = np.stack([*self.apart.values()])
        pressing = _unbalanced(pull, holders)[1] > 0.0
        sided = np.vstack([np.zeros((0, len(pull))), *(holders[n] for n in _SIDED if n in holders)])
        at, count = np.flatnonzero(self.outward), len(pressing) - len(self.apart)
        at = at[pressing[:count]]
        fixed = np.vstack([np.zeros((1, len(pull))), *above, sided[pressing]])
        free = _null_space(fixed)
        bend = free.T @ self._bend(place, error, pull) @ free
        curvature = free.T @ own.T @ own @ free - bend
        is_creeping = _gain(curvature, free.T @ pull) > 0.5 * _GAIN * length * length
        if np.linalg.norm(pull) <= _NO_PULL * np.linalg.norm(own, 2) * length:
            is_saddle = np.linalg.eigvalsh(curvature).min(initial=0.0) < -RESISTED * length
            return RestCause(SINGULAR if is_saddle else CREEPING if is_creeping else OPTIMUM)
        by = _holders(pull, holders)
        joints = tuple(self.joints[joint] for joint in at.tolist()) if LIMITS in by else ()
        near = tuple(n for n, held in zip(self.apart, pressing[count:], strict=True) if held)
        held = LIMITS if by == (LIMITS,) else HELD if by else CREEPING
        return RestCause(CREEPING if is_creeping else held, by, joints, pairs=near)

    def _bend(self, place: int, error: Floats, pull: Floats) -> Floats:
        """Return sum_i e_i H_i - sum_j lambda_j H_j for a level, shape (n, n).

        Hessians are written only in ticks of second order; otherwise nothing is bent.
        """
        stack = self.step.stack
        bend, levels = np.zeros((len(pull), len(pull))), stack.arrays
        if not levels.bent[0]:
            return bend
        above = stack.split(stack.acting_rows)[:place]
        multipliers = np.linalg.lstsq(np.vstack([*above, 0.0 * pull]).T, pull, 1e-6)[0][:-1]
        ends = np.cumsum([len(rows) for rows in above], dtype=np.int64)
        weights = [*np.split(-multipliers, ends)[:-1], error]
        acting, hessians = levels.curved[stack.ages > 0], stack.split(levels.hessians)
        for weight, hessian, curved in zip(weights, hessians, acting, strict=False):
            if curved:
                bend += np.tensordot(weight, hessian, 1)
        return bend


def _gain(curvature: Floats, pull: Floats) -> float:
    """Return the gain of half the squared error along a pull (m,), by the model of second order."""
    bends, directions = np.linalg.eigh(curvature)
    along = np.abs(directions.T @ pull)
    steps = np.where(bends * _NEARBY > along, along / np.maximum(bends, 1e-12), _NEARBY)
    return float(np.sum(along * steps - 0.5 * np.maximum(bends, 0.0) * steps**2))


def _holders(pull: Floats, holders: Mapping[str, Floats]) -> tuple[str, ...]:
    """Return the names of the holders of a pull (n,), the largest part first."""
    pull = pull / np.linalg.norm(pull)
    rest = _unbalanced(pull, holders)[0]
    # The squared part of the pull that is free without a holder; overlapping holders free none.
    parts = {each: _unbalanced(pull, holders, each)[0] ** 2 - rest**2 for each in holders}
    if max(parts.values(), default=0.0) <= _TAKEN:
        parts = {each: 1.0 - _unbalanced(pull, {each: holders[each]})[0] ** 2 for each in holders}
    return tuple(sorted((each for each in parts if parts[each] > _TAKEN), key=lambda e: -parts[e]))


def _unbalanced(
    pull: Floats, holders: Mapping[str, Floats], without: str = ""
) -> tuple[float, Floats]:
    """Return the part of a pull (n,) that no holder balances, and the pressure on each bound."""
    from scipy.optimize import nnls  # only a level that is held needs it

    kept = {name: rows for name, rows in holders.items() if name != without}
    sided = [kept.pop(name) for name in _SIDED if name in kept]
    free = _null_space(np.vstack([np.zeros((1, len(pull))), *kept.values()]))
    if not sided:
        return float(np.linalg.norm(free.T @ pull)), np.zeros(0)
    pressure, rest = nnls(free.T @ np.vstack(sided).T, free.T @ pull)
    return float(rest), pressure


def _null_space(rows: Floats) -> Floats:
    """Return an orthonormal basis of the displacements that rows (k, n) do not notice, (n, m)."""
    _, sizes, directions = np.linalg.svd(rows)
    rank = int(np.count_nonzero(sizes > 1e-9 * sizes.max(initial=0.0))) if len(rows) else 0
    basis: Floats = directions[rank:].T
    return basis
