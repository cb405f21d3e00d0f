"""Numbers that are not finite stop before they move anything."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.control.signal import SignalError, require_finite


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_non_finite_numbers_are_refused_by_name(bad: float) -> None:
    with pytest.raises(SignalError, match=r"^the value of stereo\.red is not finite: \[0\.0, "):
        require_finite(np.array([0.0, bad]), "the value of stereo.red")
    require_finite(np.array([0.0, 1e308]), "the value of stereo.red")
