"""Verbs that learn, explore and judge, through the public names alone."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import cbdsl

SEED = 3_610_000


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_learn_trials_on_workers_equals_trials_in_this_process(here: Path) -> None:
    run = cbdsl.load("searchtrack")
    texts = []
    for folder, workers in (("one", 1), ("two", 2)):
        request = cbdsl.LearnRequest(
            program=run, out=Path(folder, "p.yaml"), episodes=3, seed=SEED, trials=2,
            backend="kinematic", command="the same",
        )  # fmt: skip
        outcomes = cbdsl.learn_trials(request, workers=workers)
        assert [each.policy.name for each in outcomes] == ["p_0.yaml", "p_1.yaml"]
        assert [len(each.episodes) for each in outcomes] == [3, 3]
        assert [len(each.rewarded) for each in outcomes] == [3, 3]
        texts.append([each.policy.read_text("utf-8") for each in outcomes])
    assert texts[0] == texts[1]


def test_tasks_survive_the_way_to_a_worker(here: Path) -> None:
    (trial,) = cbdsl.LearnRequest(program=cbdsl.load("searchtrack"), out=Path("p.yaml")).tasks()
    _, exploration = cbdsl.ExploreRequest(
        ["searchtrack"], "exploring_basketball", Path("ball.yaml")
    ).task()
    _, pairs = cbdsl.ExplorePairsRequest(
        "stand", {"blue_box": "blue", "purple_box": "hue_9"}, "stacking", Path("boxes.yaml")
    ).task()
    for task in (trial, exploration, pairs):
        assert pickle.loads(pickle.dumps(task)).path == task.path


def test_learn_limits_and_sequential_actions_reach_the_trial(here: Path) -> None:
    request = cbdsl.LearnRequest(
        program=cbdsl.load("searchtrack"), out=Path("p.yaml"), episodes=2, seed=SEED,
        backend="kinematic", sequential=True, transitions=1,
    )  # fmt: skip
    (outcome,) = cbdsl.learn_trials(request)
    for episode in outcome.episodes:
        assert len(episode.transitions) <= 1
        assert all("◁" not in each.action for each in episode.transitions)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"learner": "assimilate"}, "and none is named"),
        ({"policy": "reachtouch"}, "'dexter' has learned this itself"),
        ({"policy": "reachtouch", "learner": "accommodate"}, "learns a policy from scratch"),
        ({"learner": "accommodat"}, "did you mean 'accommodate'"),
        ({"constants": {"epsilom": 1}}, "epsilon"),
    ],
)
def test_learn_rejects_unsuitable_arguments_before_any_episode(
    changes: dict[str, object], message: str, here: Path
) -> None:
    with pytest.raises(cbdsl.UsageError, match=message):
        cbdsl.learn("reachtouch", "p.yaml", backend="kinematic", **changes)  # type: ignore[arg-type]
    assert not list(here.iterdir())


def test_explore_writes_a_catalog_and_resumes_to_the_same_one(here: Path) -> None:
    seen = []

    def explore(out: str, actions: int, *, resume: bool = False) -> cbdsl.ExplorationOutcome:
        return cbdsl.explore(
            ["searchtrack"], "exploring_basketball", out, actions=actions, seed=4, resume=resume,
            backend="kinematic", on_action=lambda outcome, step: seen.append(outcome),
        )  # fmt: skip

    whole = explore("whole/ball.yaml", 4)
    assert len(seen) == 4 and whole.catalog.exists() and whole.journal.exists()
    (tried,) = whole.rewarded.values()
    assert 0 <= tried[0] <= tried[1] <= 4
    explore("parts/ball.yaml", 2)
    parts = explore("parts/ball.yaml", 4, resume=True)
    assert len(seen) == 8
    assert parts.document.affordances.keys() == whole.document.affordances.keys()
    with pytest.raises(cbdsl.UsageError, match="--resume"):
        explore("parts/ball.yaml", 4)
    assert cbdsl.check(whole.catalog) == []


def test_explore_rejects_a_stage_without_a_persistent_world(here: Path) -> None:
    with pytest.raises(cbdsl.UsageError, match="no persistent world"):
        cbdsl.explore(["searchtrack"], "table_right", "ball.yaml", backend="kinematic")


def test_evaluate_counts_rewarded_episodes_with_an_exact_interval() -> None:
    told = []
    evaluation = cbdsl.evaluate(
        "searchtrack", seed=SEED, episodes=4, backend="kinematic", cameras="ideal",
        on_episode=lambda result, succeeded: told.append((result.seed, succeeded)),
    )  # fmt: skip
    assert [seed for seed, _ in told] == list(range(SEED, SEED + 4))
    assert evaluation.successes == tuple(each.rewarded for each in evaluation.results)
    low, high = evaluation.interval
    assert low < evaluation.share <= high
    if evaluation.share == 1.0:
        assert low == pytest.approx(0.025 ** (1 / 4))
    assert f"of 4 ({100 * low:.1f}" in str(evaluation)
    with pytest.raises(cbdsl.UsageError, match="at least one"):
        cbdsl.evaluate("searchtrack", seed=SEED, episodes=0)


def is_in_view(result: cbdsl.EpisodeResult, truth: cbdsl.Truth) -> bool:
    """Return a verdict that depends on the seed and on the truth."""
    return float(truth.position(truth.objects[0])[1]) > 0 or result.seed % 2 == 0


@pytest.mark.parametrize("judge", [None, is_in_view])
def test_evaluate_with_workers_gives_the_same_results_in_order(judge: object) -> None:
    told: list[int] = []

    def rate(workers: int) -> cbdsl.SuccessRate:
        return cbdsl.evaluate(
            "searchtrack", seed=SEED, episodes=3, backend="kinematic", cameras="ideal",
            workers=workers, judge=judge,  # type: ignore[arg-type]
            on_episode=lambda result, succeeded: told.append(result.seed),
        )  # fmt: skip

    one, two = rate(1), rate(2)
    assert told == 2 * list(range(SEED, SEED + 3))
    assert one.successes == two.successes
    assert [each.predicates for each in one.results] == [each.predicates for each in two.results]
    with pytest.raises(cbdsl.UsageError, match="workers=0"):
        rate(0)


def test_explore_pairs_writes_a_meta_catalog_and_resumes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    things = {"blue_box": "blue", "purple_box": "hue_9"}
    actions: list[object] = []

    def explore(count: int, *, resume: bool = False) -> cbdsl.PairExplorationOutcome:
        return cbdsl.explore_pairs(
            "stand", things, "stacking", "boxes.yaml", actions=count, seed=4, resume=resume,
            backend="kinematic", constants={"least": 1},
            on_action=lambda outcome, step: actions.append(outcome),
        )  # fmt: skip

    first = explore(1)
    assert first.catalog == tmp_path / "boxes.yaml" and first.journal.exists()
    assert sum(tried for _, tried in first.rewarded.values()) == len(actions) == 1
    whole = explore(2, resume=True)
    assert len(actions) == 2
    assert whole.rewarded == {"purple_box_on_blue_box": (1, 1), "blue_box_on_purple_box": (0, 1)}
    assert whole.document.provenance is not None
    assert "cbdsl.explore_pairs('stand'" in whole.document.provenance.command
    assert cbdsl.check("boxes.yaml") == []
    with pytest.raises(cbdsl.UsageError, match="another thing has the channel 'blue'"):
        cbdsl.explore_pairs("stand", {**things, "slab": "blue"}, "stacking", "a.yaml")
    with pytest.raises(cbdsl.UsageError, match="'stand' tests no impedance to name"):
        cbdsl.explore_pairs("stand", things, "stacking", "a.yaml", relations="contacts")


def test_evaluate_with_a_judge_decides_by_the_truth() -> None:
    heights = []

    def is_high(result: cbdsl.EpisodeResult, truth: cbdsl.Truth) -> bool:
        heights.append(float(truth.position(truth.objects[0])[2]))
        return heights[-1] > math.inf

    evaluation = cbdsl.evaluate(
        "searchtrack", seed=SEED, episodes=2, backend="kinematic", cameras="ideal", judge=is_high
    )
    assert evaluation.successes == (False, False) and len(heights) == 2
    assert evaluation.interval == pytest.approx((0.0, 1 - 0.025**0.5))


def test_simulate_keeps_the_truth_apart_from_the_robot() -> None:
    with cbdsl.simulate("searchtrack", backend="kinematic", cameras="ideal") as simulation:
        truth, robot = simulation.truth, simulation.robot
        observed = next(iter(robot.ticks(SEED))).observation
        assert truth.objects
        for name in truth.objects:
            assert truth.position(name).shape == truth.velocity(name).shape == (3,)
            assert np.allclose(truth.rotation(name) @ truth.rotation(name).T, np.eye(3))
            assert truth.is_touched(name) is False and not truth.touching(name)
            assert truth.half_extents(name).shape == (3,) and (truth.half_extents(name) > 0).all()
            assert not hasattr(observed, name)
        assert truth.joint_positions().shape == observed.positions.shape
        assert truth.joint_velocities().shape == observed.velocities.shape
        assert truth.link_position("right_palm").shape == (3,)
        assert truth.link_rotation("right_palm").shape == (3, 3)
        truth.position(truth.objects[0])[:] = math.nan
        assert np.isfinite(truth.position(truth.objects[0])).all()
        with pytest.raises(cbdsl.UsageError, match="object in the world"):
            truth.position("unicorn")
        with pytest.raises(cbdsl.UsageError, match="did you mean 'right_palm'"):
            truth.link_position("right_plam")


@pytest.mark.parametrize("backend", ["bullet", "mujoco"])
def test_truth_of_physics_names_the_objects_that_press_on_each_other(backend: str) -> None:
    pytest.importorskip({"bullet": "pybullet"}.get(backend, backend))
    with cbdsl.simulate("reachtouch", backend=backend, cameras="ideal") as simulation:
        truth, ticks = simulation.truth, simulation.robot.ticks(SEED)
        for _ in range(5):
            next(ticks)
        forces = truth.fingertip_forces()
        assert {hand for hand, _ in forces} == {"left_hand", "right_hand"}
        assert all(force.shape == (3,) and not force.any() for force in forces.values())
        pressed = {name: truth.pressing(name) for name in truth.objects}
        assert all(names <= {*truth.objects} - {name} for name, names in pressed.items())


def test_truth_of_the_kinematic_engine_refuses_questions_about_contacts() -> None:
    with cbdsl.simulate("searchtrack", backend="kinematic", cameras="ideal") as simulation:
        next(simulation.robot.ticks(SEED))
        with pytest.raises(cbdsl.UsageError, match="use bullet or mujoco"):
            simulation.truth.pressing(simulation.truth.objects[0])


def test_propose_robot_writes_a_document_that_check_reads(here: Path) -> None:
    shipped = Path(cbdsl.load("searchtrack").urdf)
    proposal = cbdsl.propose_robot("mine", shipped, to="bodies")
    assert proposal.robot == Path("bodies/mine.yaml") and proposal.robot in proposal.files
    assert not [each for each in cbdsl.check(proposal.robot) if each.is_error]
    with pytest.raises(cbdsl.UsageError, match="is there"):
        cbdsl.propose_robot("mine", shipped, to="bodies")
    assert cbdsl.propose_robot("mine", shipped, to="bodies", force=True).robot.exists()
    with pytest.raises(cbdsl.UsageError, match="is not a name"):
        cbdsl.propose_robot("my robot", shipped)
