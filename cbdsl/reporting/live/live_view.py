"""Live view of episodes: a watcher that publishes to a feed, at the pace of a transport."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from cbdsl.backends.staging.world_state import WorldState
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.program.edit import EditTaken
from cbdsl.program.transition import Transition
from cbdsl.program.uses import of_use
from cbdsl.reporting.automaton_text import AutomatonData, automata, transition_text
from cbdsl.reporting.live.breakpoints import Breakpoints
from cbdsl.reporting.live.feed import Feed, Message, message
from cbdsl.reporting.live.frame import frame, images
from cbdsl.reporting.live.transport import Transport
from cbdsl.reporting.page import drawn_steps
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.explanation import named_runs
from cbdsl.runtime.program_composer import Composer
from cbdsl.runtime.recording import drawn, is_place, members, triple
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import Resource

# Wall time between frames, s.
_PAUSE = 1 / 30
# Number of episodes whose outcomes a page lists.
_KEPT = 50


class LiveView(EpisodeObserver):
    """Watcher of episodes for live pages.

    Without a connected page it makes no frames, and only keeps the history of the program's state.

    Args:
        feed: Feed of the pages.
        transport: Transport that paces the ticks.
        scenery: Function that returns the true state of the world, for display only.
        composer: Composer that changes the program while it runs, if changes are allowed.
        breakpoints: Breakpoints at which the transport pauses.
        clock: Function that returns the wall time, s.
    """

    def __init__(
        self,
        feed: Feed,
        transport: Transport,
        scenery: Callable[[], WorldState] | None = None,
        composer: Composer | None = None,
        breakpoints: Breakpoints | None = None,
        *,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._feed, self._transport = feed, transport
        self._scenery, self._composer, self._clock = scenery, composer, clock
        self._breakpoints = breakpoints or Breakpoints()
        self._past: list[dict[str, object]] = []
        self._kept: dict[str, Message] = {}
        self._number = 0
        self._places: list[Resource] = []
        self._names: list[str] = []
        self._known: set[str] = set()
        self._shown = 0.0
        self._last: Tick | None = None
        self._program: CheckedProgram | None = None
        self._automata: dict[str, AutomatonData] = {}

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Begin an episode; see ``EpisodeObserver.begin``."""
        self._number += 1
        self._breakpoints.begin()
        self._known, self._shown, self._last = set(), 0.0, None
        header = {
            "number": self._number,
            "stage": stage,
            "seed": seed,
            "past": self._past[-_KEPT:],
            **self._follow(program),
        }
        self._feed.begin(message("episode", header))
        # `Feed.begin` drops all messages, even a catalog that is still valid.
        for each in self._kept.values():
            self._feed.renew(each)
        self._transport.begin()

    def keep(self, lasting: Message) -> None:
        """Publish a message that remains valid across episodes, until the next one of its kind."""
        self._kept[lasting.kind] = lasting
        self._feed.renew(lasting)

    def between_ticks(self, do: Callable[[], None]) -> None:
        """Call a function in each tick, and about once a second while ticks are paused."""
        self._transport.between = do

    def take_return(self, patience: float) -> float | None:
        """Return the time to which a page asks the run to return, s; see ``Transport``."""
        return self._transport.take_return(patience)

    def run_to(self, time: float) -> None:
        """Let the next episode pass up to a time, s, and pause there; see ``Transport``."""
        self._transport.run_to(time)

    def note_transition(self, transition: Transition) -> None:
        """Note a transition; see ``EpisodeObserver.note_transition``."""
        run = None if self._last is None else self._last.run
        self._breakpoints.note_transition(transition, run)
        # A learner may choose other steps than the written policy.
        is_written = transition.depth or (run is not None and run.is_written)
        name, use = transition.program, transition.use
        automaton = of_use(self._automata, name, use) if is_written else None
        content = {
            "program": transition.title,
            "depth": transition.depth,
            "time": round(transition.time, 6),
            "state": transition.state,
            "action": transition.action,
            "next_state": transition.next_state,
            "reward": transition.reward,
            "words": "" if automaton is None else transition_text(automaton, transition),
        }
        self._feed.append(message("transition", content))

    def note_edit(self, edit: EditTaken) -> None:
        """Note an edited program; see ``EpisodeObserver.note_edit``."""
        if self._last is None:
            return
        run = self._last.run
        if self._composer is not None:
            self._composer.begin(run)
        content = {"text": f"{edit.time:.2f} s  {edit}", **self._follow(run.program)}
        self._feed.append(message("edit", content))

    def _follow(self, program: CheckedProgram) -> dict[str, object]:
        """Show the places of a program from now on, and return its parts of a message."""
        resources = [each for each in resources_of(program) if not each.is_drawn]
        self._places = [each for each in resources if is_place(each)]
        self._names = []
        self._breakpoints.follow(program)
        if program is not self._program:
            self._program, self._automata = program, automata(program)
        return {
            "program": program.name,
            "members": members(program),
            "points": [each.name for each in self._places],
            "places": self._breakpoints.places,
            "steps": drawn_steps(self._automata),
        }

    def note_tick(self, tick: Tick) -> None:
        """Note a tick; see ``EpisodeObserver.note_tick``."""
        # The composer changes the run, which an observer first meets in a tick.
        if self._last is None and self._composer is not None:
            self._composer.begin(tick.run)
        self._last = tick
        if self._breakpoints.reach(tick.run) and not self._transport.is_returning:
            self._transport.pause()
        if self._feed.watched:
            now = self._clock()
            if now - self._shown >= _PAUSE:
                self._shown = now
                self._show()
            if tick.observation.images:
                self._feed.renew(Message("images", images(tick)))
        self._transport.hold(tick.observation.time, self._show)

    def note_end(self, result: EpisodeResult) -> None:
        """Note the end of an episode; see ``EpisodeObserver.note_end``."""
        self._transport.run_to(math.nan)
        self._show()
        content = {
            "program": result.program,
            "seed": result.seed,
            "context": result.context,
            "rewarded": result.rewarded,
            "outcome": result.outcome,
            "seconds": round(result.sim_seconds, 3),
            "ending": result.ending,
        }
        self._past.append(content)
        self._feed.append(message("ending", content))

    def _show(self) -> None:
        """Publish the last tick, preceded by new controllers and bodies."""
        tick = self._last
        if tick is None:
            return
        # Frames name controllers by index and objects by name, so that both messages precede them.
        if not self._names:
            self._tell_controllers(tick)
        world = None if self._scenery is None else self._scenery()
        if world is not None:
            self._tell_bodies(world)
        content = frame(tick, self._places, world, self._names)
        content["paused"], content["speed"] = self._transport.paused, self._transport.shown_speed
        content["breakpoints"], content["met"] = self._breakpoints.shown
        if self._composer is not None:
            content["targets"] = self._composer.positions()
            content["acting"] = self._composer.acting
            content["held"] = list(self._composer.targets)
            content["stack"] = self._composer.stack
        self._feed.renew(message("frame", content))

    def _tell_controllers(self, tick: Tick) -> None:
        runs = dict(named_runs(tick.run))
        self._names = list(runs)
        content = {
            "names": self._names,
            "triples": {name: triple(run.controller) for name, run in runs.items()},
            "gains": {name: run.gain for name, run in runs.items()},
            "own": [] if self._composer is None else self._composer.own,
            "cells": [".".join(key) for key in tick.signals.touch.cells],
        }
        self._feed.append(message("controllers", content))

    def _tell_bodies(self, world: WorldState) -> None:
        """Publish the shape of each object when it first appears."""
        for name in world.names():
            if name not in self._known:
                self._known.add(name)
                parts = [drawn(part) for part in world.parts(name)]
                self._feed.append(message("body", {"name": name, "parts": parts}))
