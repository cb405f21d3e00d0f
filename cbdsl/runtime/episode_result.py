"""Result of an episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class EpisodeResult:
    """Outcome of an episode, for callers, pages and files.

    Learners need the transitions instead, and journals store them: see ``Experience``.

    Attributes:
        program, stage, context, seed: Names of program, stage and context, and the seed.
        rewarded: True if the program earned its reward.
        predicates: States of the episode, from all X to the last.
        actions: Actions between the states.
        ticks: Number of control ticks.
        sim_seconds, wall_seconds: Simulated and wall time of the episode, s.
        renderer: Name of the renderer of the images.
        ending: Reason of the end, as a sentence.
        outcome: ``success`` or ``failure`` by its program's states; empty if they define none or it
            reached none.
        guards: Duration and force for each guard that limited the motion.
        far: Controllers of the last action that are stuck: at rest beyond their tolerances.
        causes: Cause that keeps each of them from its target, by name.
        halted: True if an interrupt, an error or a late tick ended it, and not its program.
        succeeded: True if it was not halted and its program succeeded, as ``ProgramRun.succeeded``.
    """

    program: str
    stage: str
    context: str
    seed: int
    rewarded: bool
    predicates: tuple[str, ...]
    actions: tuple[str, ...]
    ticks: int
    sim_seconds: float
    wall_seconds: float
    renderer: str
    ending: str
    outcome: str = ""
    guards: tuple[str, ...] = ()
    far: tuple[str, ...] = ()
    causes: Mapping[str, str] = field(default_factory=dict)
    halted: bool = False
    succeeded: bool = False
