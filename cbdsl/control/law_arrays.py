"""Arrays of the control law in the form of compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.arrays import Floats


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
