"""Observation of a robot in one tick: the only thing that controllers ever see of the world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbdsl.sensing.channels import Regions

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
Cell = tuple[str, str]


class Loads(Mapping[Cell, Floats]):
    """Wrenches that load cells measure, by (hand, finger).

    Attributes:
        cells: in order.
        wrenches: force and torque of each, N and N m, shape (cells, 6).
    """

    __slots__ = ("cells", "wrenches")

    def __init__(self, cells: tuple[Cell, ...], wrenches: Floats) -> None:
        self.cells = cells
        self.wrenches = wrenches

    def __getitem__(self, cell: Cell) -> Floats:
        if cell not in self.cells:
            raise KeyError(cell)
        wrench: Floats = self.wrenches[self.cells.index(cell)]
        return wrench

    def __iter__(self) -> Iterator[Cell]:
        return iter(self.cells)

    def __len__(self) -> int:
        return len(self.cells)


@dataclass(slots=True)
class Observation:
    """One reading of all sensors. It has no field for what only the simulator knows.

    Attributes:
        time: since the start of the episode, s.
        positions: actuated joints in the order of the robot file's effectors, rad, shape (n,).
        velocities: of the same joints, rad/s, shape (n,).
        loads: force and torque exerted by each load cell on the world, in the world frame, N and
            N m, by (hand, finger), shape (6,) each. They include the weight of what is beyond the
            cell, and a bias.
        images: RGB, shape (height, width, 3), top row first, by camera; empty between images.
        regions: instead of images, what the channels of an ideal camera's image would hold, by
            camera and channel, the largest region first; empty between images.
        efforts: torques of the joints' drives, as these measure them, N m, shape (n,); ``None``
            where they measure none.
        exposed: when the images were taken, s, in the same clock as ``time``; ``None``
            without images, and where they are of now.
    """

    time: float
    positions: Floats
    velocities: Floats
    loads: Mapping[Cell, Floats]
    images: Mapping[str, Image]
    regions: Mapping[str, Mapping[str, Regions]] = field(default_factory=dict)
    efforts: Floats | None = None
    exposed: float | None = None
