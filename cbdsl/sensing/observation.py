"""Observation of a robot in one tick: the only input of controllers from the world."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from cbdsl.numeric.arrays import Floats, Image
from cbdsl.sensing.channels import Regions

Cell = tuple[str, str]


class Loads(Mapping[Cell, Floats]):
    """Measured wrenches of load cells, by (hand, finger).

    Attributes:
        cells: Load cells in order.
        wrenches: Force and torque of each cell, N and N m, shape (cells, 6).
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
    """One reading of all sensors, without data that only the simulator knows.

    Attributes:
        time: Time since the start of the episode, s.
        positions: Actuated joint positions in the order of the robot file's effectors, rad, shape
            (n,).
        velocities: Velocities of the same joints, rad/s, shape (n,).
        loads: Force and torque exerted by each load cell on the world, in the world frame, N and N
            m, by (hand, finger), shape (6,) each. They include a bias and the weight of all parts
            beyond the cell.
        images: RGB images, shape (height, width, 3), top row first, by camera; empty between
            images.
        regions: Regions in the images of ideal cameras, instead of images, by camera and channel,
            the largest region first; empty between images.
        efforts: Measured torques of the joints' drives, N m, shape (n,); ``None`` if the drives
            measure none.
        exposed: Time of exposure of the images, s, in the same clock as ``time``; ``None`` without
            images, and for images without delay.
    """

    time: float
    positions: Floats
    velocities: Floats
    loads: Mapping[Cell, Floats]
    images: Mapping[str, Image]
    regions: Mapping[str, Mapping[str, Regions]] = field(default_factory=dict)
    efforts: Floats | None = None
    exposed: float | None = None
