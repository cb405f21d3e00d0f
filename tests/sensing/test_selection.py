"""Chosen columns are those of numpy; what is not chosen is 0."""

from __future__ import annotations

import numpy as np

from cbdsl.sensing.selection import columns_of, columns_of_both


def test_columns_are_chosen_and_others_are_0() -> None:
    rng = np.random.default_rng(0)
    columns = np.array([5, -1, 0, 3])
    jacobian, curvature = rng.normal(size=(3, 7)), rng.normal(size=(3, 7, 7))
    kept = (columns >= 0).astype(float)
    np.testing.assert_array_equal(columns_of(jacobian, columns), jacobian[:, columns] * kept)
    expected = curvature[:, columns[:, None], columns] * kept[:, None] * kept
    np.testing.assert_array_equal(columns_of_both(curvature, columns), expected)
