"""``cb run --explain``: tables of the stack at transitions and every second."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.cli.output.narration import Narration, StackNarration
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeObservers
from tests.conftest import Checked
from tests.runtime.conftest import made_stage, on_table
from tests.runtime.synthetic import SyntheticBackend

TABLE = re.compile(r"^ +([\d.]+) s  level +phi ", re.MULTILINE)
TRANSITION = re.compile(r"^ +([\d.]+) s +\w+  \S+ -> ", re.MULTILINE)


@pytest.fixture(scope="module")
def told(checked: Checked, dexter: RobotDocument, urdf: Path, kinematics: Kinematics) -> str:
    """Return the printed lines of an episode in the synthetic world."""
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        into_file = print

        def note(*texts: str, file: Any = None, **how: Any) -> None:
            # The notice of compilation is printed into a file.
            into_file(*texts, file=file, **how) if file else lines.extend(texts)

        patch.setattr("builtins.print", note)
        backend = SyntheticBackend(dexter, urdf, lambda rng: on_table())
        stack = StackNarration()
        runner = Runner(dexter, kinematics, checked("reachtouch"), backend)

        observer = EpisodeObservers(Narration(), stack)
        result = runner.run(made_stage({}), 0, observer=observer)
        assert result.rewarded
    return "\n".join(lines)


def test_explain_prints_a_table_at_least_every_second(told: str) -> None:
    times = np.array([float(time) for time in TABLE.findall(told)])
    assert len(times) > 3
    assert np.diff(times).max() < 1.1


def test_explain_prints_a_table_at_every_transition(told: str) -> None:
    """Transitions have a table each, except the first one, which has no predecessor."""
    tables = set(TABLE.findall(told))
    assert set(TRANSITION.findall(told)[1:]) <= tables


def test_stack_is_reported_from_the_highest_priority(told: str) -> None:
    last = told[told.rindex("  level ") :].splitlines()[1:]
    names = [line.split()[0] for line in last if not line.lstrip().startswith("at their")]
    assert names[:4] == ["touch", "approach", "orient", "posture"]
