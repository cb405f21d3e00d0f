"""Imports of numba."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
import numpy as np
from numba import njit
from cbdsl.numeric.numba_settings import import_arrays_of_numba
import_arrays_of_numba()
print("scipy.linalg" in sys.modules)
print(njit(lambda a, b: a @ b)(np.eye(2), np.full((2, 2), 2.0)).tolist())
import scipy.linalg
print(scipy.linalg.inv(np.eye(1)).tolist())
"""


def test_arrays_are_imported_without_scipy_and_call_blas() -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == ["False", "[[2.0, 2.0], [2.0, 2.0]]", "[[1.0]]"]
