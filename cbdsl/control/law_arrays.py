"""Arrays of the control law in the form of compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.compiled import compiled


class LawArrays(NamedTuple):
    """Bounds and guards of the law for n joints, and the result of a tick.

    Attributes:
        limits: Lower and upper limits, rad, shape (2, n); may be infinite.
        steps: Largest displacement of each joint, rad, shape (n,).
        guards: Largest damping in the square of the Jacobians' unit, the singular value below which
            damping sets in, and the largest distance of a reference from the position, rad.
        displacement: Displacement of the joints, rad, shape (n,); NaN if an argument is not finite.
        locked: True for joints that a limit held back, shape (n,).
        singular_values: Singular values of the rows that were left to each level, unsorted, shape
            (k,); 0 for dependent rows and inactive levels.
    """

    limits: Floats
    steps: Floats
    guards: Floats
    displacement: Floats
    locked: NDArray[np.bool_]
    singular_values: Floats


@compiled
def bound_reference(place: int, before: float, after: float, law: LawArrays) -> float:
    """Return a joint's next reference, rad, within its limits and its largest step.

    A joint that is past one of its limits comes back at the law's pace.

    Args:
        place: Number of the joint among the law's n joints.
        before: Reference before the tick, rad.
        after: Requested reference, rad.
        law: Bounds.
    """
    limits, step = law.limits, law.steps[place]
    after = min(max(after, min(limits[0, place], before)), max(limits[1, place], before))
    bounded: float = min(max(after, before - step), before + step)
    return bounded
