"""Some columns of the derivatives by all joints; compiled."""

from __future__ import annotations

import numpy as np

from cbdsl.numeric.compiled import compiled_once
from cbdsl.sensing.motion import Floats, Integers


@compiled_once
def columns_of(jacobian: Floats, columns: Integers) -> Floats:
    """Columns of a Jacobian (m, all); one that is numbered -1 is 0. Returns shape (m, n)."""
    chosen = np.zeros((len(jacobian), len(columns)))
    for place in range(len(columns)):
        if columns[place] >= 0:
            for row in range(len(jacobian)):
                chosen[row, place] = jacobian[row, columns[place]]
    return chosen


@compiled_once
def columns_of_both(curvature: Floats, columns: Integers) -> Floats:
    """The same joints' derivatives of the same joints' columns, shape (m, n, n)."""
    joints = len(columns)
    chosen = np.zeros((len(curvature), joints, joints))
    for row in range(len(curvature)):
        for i in range(joints):
            for j in range(joints):
                if columns[i] >= 0 and columns[j] >= 0:
                    chosen[row, i, j] = curvature[row, columns[i], columns[j]]
    return chosen


@compiled_once
def responds(jacobian: Floats, columns: Integers) -> bool:
    """Whether any of the chosen columns of a Jacobian (m, all) has an entry other than 0."""
    for column in columns:
        for row in range(len(jacobian)):
            if jacobian[row, column] != 0.0:
                return True
    return False
