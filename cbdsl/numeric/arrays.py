"""Array types by element, for annotations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
#: Indices into other arrays.
Rows = NDArray[np.intp]
Image = NDArray[np.uint8]
#: Arrays of a structured element type.
Records = NDArray[Any]
