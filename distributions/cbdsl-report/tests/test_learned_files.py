"""Learned documents: read as written, or refused with a reason."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.yaml_text.reader import read
from cbdsl.yaml_text.writer import write
from cbdsl_report.learned_files import find_learned, read_learned
from cbdsl_report.trial_groups import measured, trial_groups
from tests.reporting.trials import write_trial


def test_read_trial_has_the_contents_of_its_files(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked", episodes=30)
    learned = read_learned(file)
    curve = learned.policy.curve
    assert curve is not None
    assert tuple(each.reward for each in learned.experiences) == curve.reward
    assert tuple(len(each.transitions) for each in learned.experiences) == curve.transitions
    assert [each.seed for each in learned.experiences] == list(range(30))
    assert {each.end for each in learned.experiences if each.reward} == {"X1"}
    assert [(model.name, model.document.effector) for model in learned.models] == [
        ("head.uniform", "head"),
        (None, "right_hand"),
    ]
    assert [joint.name for joint in learned.models[0].joints] == ["pan", "tilt"]
    assert learned.notes == ()


def test_trial_without_a_journal_uses_the_curve(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked")
    with_journal = read_learned(file)
    file.with_suffix(".episodes.jsonl").unlink()
    without = read_learned(file)
    assert with_journal.curve == without.curve
    assert len(with_journal.experiences) == len(without.curve.reward)
    assert without.experiences == ()


def test_trial_that_went_on_has_more_in_its_journal(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked", episodes=20)
    journal = file.with_suffix(".episodes.jsonl")
    whole = journal.read_text("utf-8")
    journal.write_text(whole + whole.splitlines()[-1] + '\n{"cut', encoding="utf-8")
    assert len(read_learned(file).experiences) == 20


def test_missing_item_is_reported(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked")
    (tmp_path / "walked_head.yaml").unlink()
    learned = read_learned(file)
    assert [model.document.effector for model in learned.models] == ["right_hand"]
    assert learned.notes == (
        "Without the internal model walked_head: unknown model 'walked_head'.",
    )


def test_model_with_other_joints_than_its_effector_is_reported(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked")
    path = tmp_path / "walked_right_hand.yaml"
    model = read(path, ModelDocument).document
    density = model.density.model_copy(update={"deviation": (0.1,)})
    write(model.model_copy(update={"density": density}), path)
    learned = read_learned(file)
    assert [model.document.effector for model in learned.models] == ["head"]
    assert "it needs 4 angles, as 'right_hand' has" in learned.notes[0]


@pytest.mark.parametrize("content", ["", "[]\n[]\n", '{"a": 1}\n{"b"', '{}\n{"transitions": []}\n'])
def test_damaged_journal_is_an_error(tmp_path: Path, content: str) -> None:
    file = write_trial(tmp_path, "walked")
    file.with_suffix(".episodes.jsonl").write_text(content, encoding="utf-8")
    wanted = r"walked\.episodes\.jsonl(, line 2: it lacks| is not a journal|: holds 0)"
    with pytest.raises(UsageError, match=wanted) as caught:
        read_learned(file)
    assert "Error" not in str(caught.value)


def test_folder_has_its_policies_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    for number in (10, 9, 0):
        write_trial(tmp_path, f"walked_{number}", seed=number)
    names = [file.name for file in find_learned(tmp_path)]
    assert names == ["walked_0.yaml", "walked_9.yaml", "walked_10.yaml"]


def test_mistakes_are_reported(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked")
    with pytest.raises(UsageError, match="no such file"):
        find_learned(tmp_path / "none.yaml")
    with pytest.raises(UsageError, match=r"walked\.yaml"):
        find_learned(file.with_suffix(".episodes.jsonl"))
    (tmp_path / "empty").mkdir()
    with pytest.raises(UsageError, match="no policy"):
        find_learned(tmp_path / "empty")
    with pytest.raises(DiagnosticsError):
        read_learned(tmp_path / "walked_head.yaml")
    policy = read(file, PolicyDocument).document
    write(policy.model_copy(update={"curve": None}), file)
    with pytest.raises(UsageError, match="cb show policy"):
        read_learned(file)


def test_trials_that_differ_in_chance_are_one_group(tmp_path: Path) -> None:
    files = [write_trial(tmp_path, f"walked_{seed}", seed, 10 + seed) for seed in range(3)]
    files.append(write_trial(tmp_path, "other", alpha=0.5))
    found = trial_groups([read_learned(file) for file in files])
    assert [(each.name, len(each.trials), each.episodes) for each in found] == [
        ("walked", 3, 10),
        ("other", 1, 20),
    ]


def test_curves_are_those_of_the_journals(tmp_path: Path) -> None:
    file = write_trial(tmp_path, "walked")
    rows = file.with_suffix(".episodes.jsonl").read_text("utf-8").splitlines()[1:]
    episodes = [json.loads(row)["transitions"] for row in rows]
    (group,) = trial_groups([read_learned(file)])
    found = measured(group)
    rates = [sum(each["reward"] for each in own) / len(own) for own in episodes]
    assert found.rate[1].middle.tolist() == pytest.approx(rates)
    assert found.rate[10].middle[-1] == pytest.approx(sum(rates[-10:]) / 10)
    assert found.hits[1].middle.tolist() == [float(rate > 0) for rate in rates]
