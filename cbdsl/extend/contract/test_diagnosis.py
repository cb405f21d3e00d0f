"""Contract of diagnoses: causes within the episode, which do not depend on the scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cbdsl.cli.main import build_app
from cbdsl.reporting.diagnoses import DIAGNOSES
from cbdsl.reporting.recorded import read_recording


@pytest.mark.parametrize("name", DIAGNOSES.usable_names())
def test_causes_lie_within_the_episode_and_rest_on_no_scene(name: str, tmp_path: Path) -> None:
    words = ["run", "reach", "--stage", "absent", "--backend", "kinematic", "--record"]
    CliRunner().invoke(build_app(["run"]), [*words, str(tmp_path)])
    recorded = read_recording(tmp_path / "episode_0.json")
    causes = DIAGNOSES.get(name)(recorded)
    assert all(0.0 <= each.time <= recorded.arrays["time"][-1] for each in causes)
    assert all(each.kind and each.text for each in causes)
    blank = {**recorded.arrays, "scene": np.full_like(recorded.arrays["scene"], np.nan)}
    assert DIAGNOSES.get(name)(replace(recorded, arrays=blank)) == causes
