"""Observers of episodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick


class ReturnRequest(Exception):  # noqa: N818 (a request is no error)
    """Request of an observer to run the episode again up to an earlier time.

    Attributes:
        time: Simulated time, s.
    """

    def __init__(self, time: float) -> None:
        super().__init__(f"back to {time:.2f} s")
        self.time = time


class EpisodeObserver:
    """Observer of episodes; a method ignores its call unless a subclass overrides it.

    The world waits during each call.
    """

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Note that an episode of a program begins on a stage."""

    def note_transition(self, transition: Transition) -> None:
        """Note that the state of a program changed."""

    def note_edit(self, edit: EditTaken) -> None:
        """Note that an edited program has replaced one that runs."""

    def note_tick(self, tick: Tick) -> None:
        """Note that a control tick is over, before its references are applied."""

    def note_end(self, result: EpisodeResult) -> None:
        """Note that the episode ended, for any reason."""


class EpisodeObservers(EpisodeObserver):
    """Observer that passes each call to several observers.

    Args:
        observers: Observers, in the order of their calls.
    """

    def __init__(self, *observers: EpisodeObserver) -> None:
        self._observers = observers

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Pass the begin of an episode on."""
        for observer in self._observers:
            observer.begin(program, stage, seed)

    def note_transition(self, transition: Transition) -> None:
        """Pass a transition on."""
        for observer in self._observers:
            observer.note_transition(transition)

    def note_edit(self, edit: EditTaken) -> None:
        """Pass the edit of a program on."""
        for observer in self._observers:
            observer.note_edit(edit)

    def note_tick(self, tick: Tick) -> None:
        """Pass a tick on."""
        for observer in self._observers:
            observer.note_tick(tick)

    def note_end(self, result: EpisodeResult) -> None:
        """Pass the end of an episode on."""
        for observer in self._observers:
            observer.note_end(result)


@dataclass(frozen=True)
class EpisodeListeners(EpisodeObserver):
    """Observer that calls functions.

    Attributes:
        on_transition: Function of each transition, if any.
        on_tick: Function of each control tick, if any.
        on_end: Function of the result, if any.
    """

    on_transition: Callable[[Transition], object] | None = None
    on_tick: Callable[[Tick], object] | None = None
    on_end: Callable[[EpisodeResult], object] | None = None

    def note_transition(self, transition: Transition) -> None:
        """Call the function of a transition."""
        if self.on_transition is not None:
            self.on_transition(transition)

    def note_tick(self, tick: Tick) -> None:
        """Call the function of a tick."""
        if self.on_tick is not None:
            self.on_tick(tick)

    def note_end(self, result: EpisodeResult) -> None:
        """Call the function of the result."""
        if self.on_end is not None:
            self.on_end(result)
