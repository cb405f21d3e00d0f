"""Views of one transition of a calibration, and the views in a journal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cbdsl.extend.command import RowForm
from cbdsl_calibration.hand_view import HandView


class HandViews(NamedTuple):
    """Views of one transition.

    Attributes:
        hold: Number of the hold.
        views: Views of the held ball.
    """

    hold: int
    views: Sequence[HandView]


def _read(row: Mapping[str, Any]) -> HandViews:
    return HandViews(int(row["hold"]), [_view(view) for view in row["views"]])


def _view(row: Mapping[str, Any]) -> HandView:
    """Return the view in a row of JSON."""
    shapes = {"position": (3,), "rotation": (3, 3), "point": (2,), "tips": (3, 3)}
    arrays = {
        key: np.array(row[key], dtype=np.float64).reshape(shape) for key, shape in shapes.items()
    }
    return HandView(row["camera"], area=float(row["area"]), hold=int(row["hold"]), **arrays)


def _write(row: HandViews) -> dict[str, Any]:
    views = [
        {key: np.asarray(value).tolist() for key, value in view._asdict().items()}
        for view in row.views
    ]
    return {"hold": row.hold, "views": views}


#: Rows of the journal of a calibration.
HAND_VIEWS = RowForm("calibration", "the views of a transition", _read, _write)
