"""Trials: the inputs of an episode, and its outcome."""

from __future__ import annotations

import pytest

from cbdsl.learning.constants import AccommodateConstants
from cbdsl.program.binding import internal_models
from cbdsl.program.checked import CheckedProgram
from cbdsl.training.trial import Trial
from cbdsl.types.resource import KernelSample, UniformSample
from tests.training.toy import ToyEpisodeRunner, toy_trial


def drawn_from(program: CheckedProgram) -> object:
    return internal_models(program)["head.uniform"].source


def test_density_is_uniform_at_first_and_grows_with_each_reward() -> None:
    runner, trial = ToyEpisodeRunner(), toy_trial()
    rewarded = []
    for _ in range(6):
        rewarded.append(sum(each.reward for each in trial.experiences))
        trial.run(runner)
    sources = [drawn_from(program) for program in runner.programs]
    assert isinstance(sources[0], UniformSample)
    learned = [source for source in sources[1:] if isinstance(source, KernelSample)]
    assert [len(source.samples) for source in learned] == [count for count in rewarded if count]


def test_every_part_of_a_program_draws_from_the_same_density() -> None:
    runner, trial = ToyEpisodeRunner(), toy_trial()
    while not trial.learned_models():
        trial.run(runner)
    trial.run(runner)
    program = runner.programs[-1]
    references = {
        controller.reference
        for primitives in (
            *(action.composition.primitives for action in program.actions if action.composition),
            program.primitives.values(),
        )
        for primitive in primitives
        for controller in primitive.controllers
        if controller.name == "search"
    }
    assert len(references) == 1


@pytest.mark.parametrize("exploring", [None, 3, 5, 6])
def test_replayed_trial_is_the_same_trial(exploring: int | None) -> None:
    constants = AccommodateConstants(exploring_episodes=exploring)
    lived, told = (Trial(toy_trial().program, constants, 1) for _ in range(2))
    for _ in range(5):
        told.replay(lived.run(ToyEpisodeRunner()))
    assert told.run(ToyEpisodeRunner()) == lived.run(ToyEpisodeRunner())


def test_no_two_episodes_of_no_two_trials_share_a_seed() -> None:
    program = toy_trial().program
    trials = [Trial(program, toy_trial().constants, s, n) for s in range(4) for n in range(4)]
    seeds = [trial.run(ToyEpisodeRunner()).seed for trial in trials for _ in range(5)]
    assert len(set(seeds)) == len(seeds)
