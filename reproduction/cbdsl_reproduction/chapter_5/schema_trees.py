"""Schema trees: choice of arms and expected reward by visual features (Figures 5.10 and 5.11).

Ten trials of ASSIMILATE start from the shipped policy of REACHTOUCH, with 50 episodes each. Their
trees are evaluated on the features at the first choice of held-out episodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from cbdsl.api.allocation import allocated
from cbdsl.api.control import Kinematics
from cbdsl.api.documents import PolicyDocument, SchemaDocument, digest_of_text
from cbdsl.api.drawing import draw_schema
from cbdsl.api.learning import ASSIMILATE, Assimilate, AssimilateConstants, TriedContext
from cbdsl.api.program import (
    CheckedProgram,
    Features,
    Ranking,
    SchemaPolicy,
    Split,
    Tree,
    decide,
    splits,
)
from cbdsl.api.shipped import shipped_path, shipped_program
from cbdsl.api.trials import BackendEpisodeRunner, Trial, embody
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.estimate import mean_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_trials import kept_trials
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above
from cbdsl_reproduction.source_features import with_source_features
from cbdsl_reproduction.trial_digest import trial_digest

_PROGRAM, _STAGE, _BACKEND = "reachtouch", "near_and_far_training", "kinematic"
_TRIALS, _EPISODES, _ASKED = 10, 50, 60
_QUICK = (1, 10, 12)
# Least share of correct answers of a trial in one context, %.
_MOST = 90.0
# Allocation of the source's tree and its description, by context of the stage.
_FIRST = {
    "large": ("reachtouch_bimanual", "large: both arms"),
    "left": ("left_arm", "small and still: the arm on that side"),
    "right": ("right_arm", "small and still: the arm on that side"),
}
_FAR = "far"
_CHOOSES = {
    context: Claim(
        "Section 5.3.1, Figure 5.10",
        f"Figure 5.10, {context}: trials that choose {allocation}",
        "%",
        report,
        above(50.0),
    )
    for context, (allocation, report) in _FIRST.items()
}
_REACH = "Section 5.3.1, Figure 5.11"
_EXPECTS = {
    is_far: Claim(_REACH, f"Figure 5.11, {name}", "%", report, above(50.0))
    for is_far, name, report in (
        (True, "out of reach: trials that expect no reward", "reward is unlikely"),
        (False, "in reach: trials that expect reward", "reward is likely"),
    )
}
_ASKS = Claim(
    _REACH,
    "Figure 5.11: trials that ask for the distance forward first",
    "%",
    "asked first",
    above(50.0),
)
_ENDS = Claim(
    _REACH, "Figure 5.11: distance forward where reach ends", "m", "1.17 on the original robot"
)
CLAIMS: Claims = {"fig-5.10-5.11": (*_CHOOSES.values(), *_EXPECTS.values(), _ASKS, _ENDS)}


class Question(NamedTuple):
    """Question to the trees: the features of a context at its first choice."""

    context: str
    features: Features


class AssimilationTrial(NamedTuple):
    """Trial of ASSIMILATE.

    Attributes:
        things: Name of the program.
        seed: Number of the trial.
        tried: Contexts with the allocations tried in them.
    """

    things: str
    seed: int
    tried: tuple[TriedContext, ...]


class Trees(NamedTuple):
    """Trees of a trial: the ranking of allocations, and the probability of reward."""

    choice: Tree[Ranking]
    reward: Tree[float]


@dataclass(frozen=True)
class SchemaPicture:
    """Picture of the trees of a schema.

    Attributes:
        name: Name of its file, without suffix.
        title: Title of the picture.
        schema: Schema that holds the trees.
    """

    name: str
    title: str
    schema: SchemaDocument

    def svg(self) -> str:
        """Return the picture as the text of an SVG file."""
        return draw_schema(self.schema)

    def data(self) -> dict[str, object]:
        """Return the schema, for scripts."""
        return self.schema.model_dump(mode="json", by_alias=True, exclude_none=True)


def run(settings: RunSettings) -> Result:
    """Learn several times, and evaluate the trees."""
    usual, episodes, asked = _QUICK if settings.quick else (_TRIALS, _EPISODES, _ASKED)
    count = settings.trials or usual
    program, runner = _prepared()
    first = settings.seed  # trials draw their own seeds
    known = list(questions(program, runner, range(first, first + asked)))
    trials = kept_trials(
        settings.folder / "assimilations.jsonl",
        {_PROGRAM: range(count)},
        partial(_digest, settings.seed, episodes),
        AssimilationTrial,
        partial(_run_trials, program, runner, settings.seed, episodes),
        settings.progress,
    )
    learners = [_learner(program, each.tried) for each in trials[_PROGRAM]]
    trees = [Trees(each.choice(), each.reward()) for each in learners]
    schema = learners[0].document(_PROGRAM, program)
    pictures = [SchemaPicture("schema_trees", "The trees of the first trial", schema)]
    return Result(tuple(quantities(trees, known, settings.seed)), tuple(pictures), _NOTES)


_NOTES = (
    f"Ten trials of {_EPISODES} episodes on stage {_STAGE}, {_BACKEND} with ideal cameras, three "
    "in ten of the episodes out of reach. The source's first tree comes of 25 episodes within "
    "reach, its second of 50 others. Nothing moves on this stage, so that the source's branch for "
    "moving things, the arm that anticipates them, is not asked for.",
)


def _run_trials(
    program: CheckedProgram,
    runner: BackendEpisodeRunner,
    seed: int,
    episodes: int,
    things: str,
    numbers: Iterable[int],
) -> Iterator[AssimilationTrial]:
    for number in numbers:
        trial = Trial(program, AssimilateConstants(), seed, number, ASSIMILATE)
        for _ in range(episodes):
            trial.run(runner)
        assert isinstance(trial.learner, Assimilate)
        yield AssimilationTrial(things, number, trial.learner.contexts)


def _learner(program: CheckedProgram, tried: Iterable[TriedContext]) -> Assimilate:
    """Return a learner with the experience of some contexts."""
    learner = Assimilate([], AssimilateConstants())
    learner.adopt(program)
    learner.recall(tried)
    return learner


def _digest(seed: int, episodes: int, program: str) -> str:
    """Return the digest of all inputs of a trial except its number."""
    policy = shipped_path(PolicyDocument, program).read_text(encoding="utf-8")
    return digest_of_text(f"{trial_digest(program, {}, _STAGE)} {seed} {episodes}\n{policy}")


def _prepared() -> tuple[CheckedProgram, BackendEpisodeRunner]:
    """Return the shipped program with all its allocations and its policy, and its runner."""
    request = shipped_program(_PROGRAM, stage=_STAGE)
    program, robot = with_source_features(allocated(request, _PROGRAM)), request.robot
    body = embody(_BACKEND, robot, request.urdf)
    runner = BackendEpisodeRunner(robot, Kinematics(robot, request.urdf), body, request.stage)
    return program._replace(transition_time=8.0, idle_time=1.0), runner


def questions(
    program: CheckedProgram, runner: BackendEpisodeRunner, seeds: Sequence[int]
) -> Iterator[Question]:
    """Yield the features of the first informed choice of each episode."""
    assert program.schema is not None
    names, wanted = tuple(program.schema.allocations), set(program.schema.components)
    # The ranking is fixed, so that no tree under judgement has an influence on the questions.
    policy = SchemaPolicy(program, lambda features: names, gives_up=False)
    for seed in seeds:
        episode = runner.run(program, policy, seed, lambda transition: None)
        for transition in episode.transitions:
            if transition.features.keys() >= wanted:
                yield Question(episode.context, dict(transition.features))
                break


def quantities(trees: Sequence[Trees], known: Sequence[Question], seed: int) -> Iterator[Quantity]:
    """Yield the shares of trials whose trees have the source's branches, and the limit of reach."""
    for context, (allocation, _) in _FIRST.items():
        rights = [
            _share([(decide(each.choice, q.features) or ("",))[0] == allocation for q in asked])
            for each in trees
            if (asked := [q for q in known if q.context == context])
        ]
        yield _trials(_CHOOSES[context], rights)
    for is_far, claim in _EXPECTS.items():
        rights = [
            _share([((decide(each.reward, q.features) or 0.0) < 0.5) == is_far for q in asked])
            for each in trees
            if (asked := [q for q in known if (q.context == _FAR) == is_far])
        ]
        yield _trials(claim, rights)
    ends = [_forward(each.reward) for each in trees]
    asking = [end for end in ends if end is not None]
    yield percentage(_ASKS, len(asking), len(trees))
    if len(asking) > 1:
        yield mean_of(
            _ENDS,
            asking,
            seed=seed,
            note="not judged: nothing stands between 0.8 and 1.15 m, where any such tree has it",
        )


def _share(rights: Sequence[bool]) -> float:
    return 100 * sum(rights) / len(rights)


def _trials(claim: Claim, rights: Sequence[float]) -> Quantity:
    # A trial is one sample: all of its answers come from the same pair of trees.
    right = sum(each >= _MOST for each in rights)
    note = f"in {_MOST:g} % of the contexts or more"
    return percentage(claim, right, len(rights), note=note)


def _forward(tree: Tree[Any]) -> float | None:
    """Return the threshold of the first split, if it splits by the distance forward."""
    first = next(splits(tree), None)
    is_forward = isinstance(first, Split) and first.feature == "place.x"
    return first.threshold if first is not None and is_forward else None
