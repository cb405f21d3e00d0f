"""Journal of a calibration: the recorded views, from which an interrupted one continues."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cbdsl.calibration.hand_view import HandView
from cbdsl.runtime.line_journal import LineJournal, damaged

_WHAT = "calibration"


class WatchJournal(LineJournal):
    """File of JSON lines: the identity of a calibration, then the views of each transition.

    Args:
        path: Path of the file; the calibration continues with another hold if the file exists.
        identity: All inputs of the views, as JSON data.

    Attributes:
        views: Views in the file.
        transitions: Number of recorded transitions.
        hold: Number of the hold that begins now.

    Raises:
        JournalError: If the file belongs to another calibration, is no journal, or is being
            written.
        OSError: If the file cannot be read or written.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        super().__init__(path, identity, _WHAT)
        self.views: list[HandView] = []
        try:
            for number, row in enumerate(self.rows, 2):
                self.views += _views(row, path, number)
        except BaseException:
            self._file.close()
            raise
        self.transitions = len(self.rows)
        self.hold = 1 + self.rows[-1]["hold"] if self.rows else 0

    def append(self, views: Sequence[HandView]) -> None:
        """Append the views of a transition and flush them to disk.

        Raises:
            OSError: If the views cannot be written.
        """
        rows = [
            {key: np.asarray(value).tolist() for key, value in view._asdict().items()}
            for view in views
        ]
        self.append_row({"hold": self.hold, "views": rows})
        self.views += views
        self.transitions += 1


def _views(row: Mapping[str, Any], path: Path, number: int) -> list[HandView]:
    try:
        int(row["hold"])
        return [_view(each) for each in row["views"]]
    except (KeyError, TypeError, ValueError) as error:
        problem = f"it holds no views ({type(error).__name__}: {error})"
        raise damaged(path, number, problem, _WHAT) from error


def _view(row: Mapping[str, Any]) -> HandView:
    """Return the view in a row of JSON."""
    shapes = {"position": (3,), "rotation": (3, 3), "point": (2,), "tips": (3, 3), "forces": (3, 3)}
    arrays = {
        key: np.array(row[key], dtype=np.float64).reshape(shape) for key, shape in shapes.items()
    }
    return HandView(row["camera"], area=float(row["area"]), hold=int(row["hold"]), **arrays)
