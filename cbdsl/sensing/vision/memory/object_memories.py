"""Memories of the objects of one channel, and the regions that show them."""

from __future__ import annotations

from cbdsl.documents.robot import Regions
from cbdsl.numeric.arrays import Floats
from cbdsl.sensing.vision.association.sighting import Sighting
from cbdsl.sensing.vision.memory.memory import PositionMemory


class ObjectMemories:
    """Memories and sightings of the objects of one channel, by number.

    Args:
        settings: Number of distinguished objects, and parameters of their memories.
        cameras: Number of cameras; only two give positions.

    Attributes:
        memories: Memories by number, from 0.
        sightings: Sightings in the newest images, by camera and number of the object. A region that
            shows no remembered object has the lowest free number.
    """

    def __init__(self, settings: Regions, cameras: int) -> None:
        count = settings.instances if cameras == 2 else 0
        self.memories = tuple(PositionMemory(settings) for _ in range(count))
        self.sightings: list[dict[int, Sighting]] = [{} for _ in range(cameras)]

    def reset(self) -> None:
        """Forget everything."""
        self.forget_sightings()
        for memory in self.memories:
            memory.reset()

    def forget_sightings(self) -> None:
        """Forget the images before."""
        for each in self.sightings:
            each.clear()

    @property
    def known(self) -> list[int]:
        """Numbers of the remembered objects."""
        return [k for k, memory in enumerate(self.memories) if memory.position is not None]

    @property
    def free(self) -> int | None:
        """Lowest number without a remembered object."""
        return next((k for k, each in enumerate(self.memories) if each.position is None), None)

    def position(self, number: int) -> Floats:
        """Return the position of a remembered object, m, shape (3,)."""
        position = self.memories[number].position
        assert position is not None
        return position

    def ball(self, number: int) -> tuple[Floats, float]:
        """Return position and radius of a remembered object, m."""
        return self.position(number), self.memories[number].radius
