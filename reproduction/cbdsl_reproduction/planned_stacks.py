"""Stacks of three in an order planned from a meta-catalog, on the stage ``stacking``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from cbdsl.api.documents import MetaCatalogDocument, StageDocument
from cbdsl.api.learning import StackPlan, plan_stack, support_graph
from cbdsl.api.sensing import EpisodeListeners
from cbdsl.api.shipped import shipped_document
from cbdsl_reproduction.constellation_trials import STAGE
from cbdsl_reproduction.simulation_fixture import SimulationFixture, simulation_fixture
from cbdsl_reproduction.stack_trials import StackJudge

_PROGRAM = "stack_three"
# Parameters of the program for the objects of a plan, from below.
_ROLES = ("goal", "middle", "feature")


class PlannedStack(NamedTuple):
    """Trial of a planned stack.

    Attributes:
        seed: Seed of the episode, and of the initial order of the objects.
        things: Context with the initial order of the objects, from left to right.
        order: Planned order, from below.
        expected: Probability of success of the plan.
        stands: True if each object rests only on the one below, by the simulator's ground truth.
        ending: Ending of the program.
    """

    seed: int
    things: str
    order: tuple[str, ...]
    expected: float
    stands: bool
    ending: str


def run_planned(
    catalog: MetaCatalogDocument, seeds: Iterable[int], engine: str, cameras: str | None
) -> Iterator[PlannedStack]:
    """Plan and build a stack of three, once for each seed.

    Args:
        catalog: Meta-catalog with the objects and their support relations.
        seeds: Seeds of the trials.
        engine, cameras: Engine and cameras of the simulation.

    Raises:
        BackendError, EpisodeError: The simulator cannot run it.
        ImportError: The simulator is not installed.
        ValueError: The meta-catalog has no stack of the presented objects.
    """
    stage = shipped_document(StageDocument, STAGE)
    shown = {
        name: tuple(context.placed)
        for name, context in stage.contexts.items()
        if len(context.placed) == len(_ROLES)
    }
    names = sorted(shown)
    labs: dict[tuple[str, ...], SimulationFixture] = {}
    with ExitStack() as open_labs:
        for seed in seeds:
            things = names[int(np.random.default_rng(seed).integers(len(names)))]
            plan = plan_stack(support_graph(catalog, shown[things]), len(_ROLES))
            # The parameters of the program depend on the order; the simulation of an order is
            # reused.
            if plan.order not in labs:
                channels = [catalog.things[name].feature for name in plan.order]
                values = dict(zip(_ROLES, channels, strict=True))
                lab = simulation_fixture(_PROGRAM, values, STAGE, engine, cameras)
                labs[plan.order] = open_labs.enter_context(lab)
            yield _build(labs[plan.order], plan, things, seed)


def _build(lab: SimulationFixture, plan: StackPlan, things: str, seed: int) -> PlannedStack:
    judge = StackJudge(lab.backend.truth, plan.order)
    result = lab.runner().run(
        lab.stage, seed, things, observer=EpisodeListeners(on_tick=judge.note)
    )
    stands = judge.conclude(things, seed, result.ending).stands
    return PlannedStack(seed, things, plan.order, plan.probability, stands, result.ending)
