"""Export ``lerobot``: recorded episodes as a dataset of LeRobot."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.extend.export import Export

if TYPE_CHECKING:
    from cbdsl.extend.export import Recorded

Fps = Annotated[
    int | None, typer.Option("--fps", min=1, help="Frames per second [the rate of the images].")
]
Task = Annotated[
    str | None, typer.Option("--task", help="Sentence that names the task [the program's name].")
]
Videos = Annotated[
    bool,
    typer.Option("--videos", help="Store images as MP4 videos, which are smaller and lossy [PNG]."),
]
Signals = Annotated[
    str | None,
    typer.Option(
        "--signals",
        help="Recorded signals for observation.environment_state, such as "
        "right_arm.position,stereo.red; NaN while undefined [none].",
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an existing dataset.")]


def write(
    recordings: Iterable[Recorded],
    target: Path,
    *,
    fps: Fps = None,
    task: Task = None,
    signals: Signals = None,
    videos: Videos = False,
    overwrite: Overwrite = False,
) -> str:
    """Write recorded episodes as a dataset of LeRobot, format v3.0, to train policies.

    Each frame has joint positions, velocities, load cells and images, the joint references as the
    action, rewards, and the state and action of the program.
    """
    from cbdsl_lerobot.dataset import write_dataset

    episodes, frames = write_dataset(
        recordings,
        target,
        rate=fps,
        task=task,
        signals=tuple(signals.split(",")) if signals else (),
        videos=videos,
        overwrite=overwrite,
    )
    return f"{frames} frames of {episodes} episode{'s' if episodes > 1 else ''}"


LEROBOT = Export(write, folder="lerobot")
