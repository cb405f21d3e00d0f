"""The experimenter: puts up what an episode shows, and does with the thing what is to be done."""

from __future__ import annotations

from cbdsl.backends.bullet.deed import Carry, Deed, Hold, Return, Throw
from cbdsl.backends.bullet.scene import Scene
from cbdsl.backends.bullet.truth import Truth
from cbdsl.backends.staging.presentation import Movement, Presentation


class Experimenter:
    """Acts in the world as a person would beside the robot, and sees all of it.

    Args:
        client: the simulator.
        presentation: what is shown in this episode.
        scene: where fixtures and things are put.
        truth: what the experimenter sees.
    """

    def __init__(self, client: int, presentation: Presentation, scene: Scene, truth: Truth) -> None:
        self._client = client
        self._scene = scene
        self._truth = truth
        self._deeds: list[Deed] = []
        self._shown: str | None = None
        self._removal = presentation.removed
        for fixture in presentation.fixtures:
            scene.add(*fixture)
        if presentation.thing is not None:
            self._shown = presentation.thing.name
            body = scene.add(*presentation.thing)
            self._deeds = self._planned(presentation, self._shown, body)

    def _planned(self, presentation: Presentation, name: str, body: int) -> list[Deed]:
        deeds: list[Deed] = []
        if presentation.held_until is not None:
            deeds.append(Hold(self._client, self._truth, name, body, presentation.held_until))
        if presentation.movement is not None:
            deeds.append(self._moved(presentation.movement, name, body))
        if presentation.returned_after is not None:
            delay = presentation.returned_after
            deeds.append(Return(self._client, self._truth, name, body, delay))
        return deeds

    def _moved(self, movement: Movement, name: str, body: int) -> Deed:
        if movement.thrown:
            return Throw(self._client, body, movement)
        return Carry(self._client, self._truth, name, body, movement)

    def act(self, time: float) -> bool:
        """Do what is to be done at this time since the episode began, s.

        Returns:
            Whether something was taken out of the world.
        """
        if self._shown is not None and time >= self._removal:
            self._scene.remove(self._shown)
            self._shown, self._deeds = None, []
            return True
        self._deeds = [deed for deed in self._deeds if not deed.act(time)]
        return False
