"""Export of joint positions as a table of comma-separated values."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.extend.export import Export, replace_file

if TYPE_CHECKING:
    from cbdsl.extend.export import Recorded

Digits = Annotated[int, typer.Option("--digits", min=0, help="Digits behind the decimal point.")]


def write(recordings: "Iterable[Recorded]", target: Path, *, digits: Digits = 3) -> str:
    """Write the joint positions of recorded episodes as comma-separated values, in rad or m."""
    (recorded,) = recordings
    rows = [",".join(["time", *recorded.summary["joints"]])]
    for time, positions in zip(recorded.arrays["time"], recorded.arrays["positions"], strict=True):
        rows.append(",".join(f"{value:.{digits}f}" for value in (time, *positions)))
    replace_file(target, lambda file: file.write("\n".join(rows).encode()))
    return f"{len(rows) - 1} rows"


TABLE = Export(write, suffix=".csv")
