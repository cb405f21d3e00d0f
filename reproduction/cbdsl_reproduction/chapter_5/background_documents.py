"""Background models as documents: expected postures for each channel (Section 5.2.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from cbdsl.api.documents import Kernel, ModelDocument, write

# Deviation of expected from tracked postures, rad: a head at rest is within 5 deg of the tracked
# object.
_BANDWIDTH = 0.05

Postures = Sequence[tuple[float, ...]]


def background_documents(
    robot: str, effector: str, stage: str, tracked: Mapping[str, Postures]
) -> Iterator[ModelDocument]:
    """Yield a model for each channel that was tracked at least once.

    Args:
        robot: Name of the robot.
        effector: Effector that moves its cameras.
        stage: Name of the stage.
        tracked: Configurations in which a channel was tracked, rad, by the channel's name.
    """
    for channel, postures in tracked.items():
        if postures:
            yield ModelDocument(
                cbdsl=1,
                kind="model",
                name=f"{stage}_{channel}",
                description=f"Where {channel} was tracked on {stage} (fig-5.3-5.5).",
                robot=robot,
                effector=effector,
                channel=channel,
                density=Kernel(
                    form="kernel",
                    samples=tuple(postures),
                    bandwidth=(_BANDWIDTH,) * len(postures[0]),
                ),
            )


def write_backgrounds(
    folder: Path, robot: str, effector: str, stage: str, tracked: Mapping[str, Postures]
) -> None:
    """Write the background models to a folder, each to a file of its name."""
    for document in background_documents(robot, effector, stage, tracked):
        write(document, folder / f"{document.name}.yaml")
