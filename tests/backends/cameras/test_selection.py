"""Cameras are chosen apart from the engine."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BACKENDS, BackendError, embody
from cbdsl.backends.cameras import opengl
from cbdsl.backends.cameras.selection import make_cameras
from cbdsl.cli.main import main
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.episode import Runner
from cbdsl.sensing.channels import Region, Regions
from cbdsl.yaml_text.library import Library
from tests.backends.conftest import URDF, stage_named
from tests.conftest import Checked


@pytest.mark.parametrize(
    ("name", "cameras", "renderer"),
    [("bullet", "ideal", "ideal cameras"), ("kinematic", "rendered", "opengl")],
)
def test_engine_runs_with_the_cameras_of_the_other(
    dexter: RobotDocument,
    kinematics: Kinematics,
    checked: Checked,
    name: str,
    cameras: str,
    renderer: str,
) -> None:
    try:
        backend = embody(name, dexter, URDF, cameras=cameras)
    except BackendError as error:
        pytest.skip(str(error))
    stage = stage_named("table_right")
    result = Runner(dexter, kinematics, checked("reachtouch"), backend).run(stage, 3)
    assert result.rewarded, result.ending
    assert result.renderer.startswith(renderer)
    observation = backend.observe()
    assert not (observation.images if cameras == "ideal" else observation.regions)
    backend.close()


def _seen(dexter: RobotDocument, name: str) -> Mapping[str, Mapping[str, Regions]]:
    backend = embody(name, dexter, URDF, cameras="ideal")
    backend.reset(stage_named("table_right"), "in_view", np.random.default_rng(2))
    regions = backend.observe().regions
    backend.close()
    return regions


def test_ideal_cameras_see_the_same_on_every_engine(dexter: RobotDocument) -> None:
    one, other = _seen(dexter, "bullet"), _seen(dexter, "kinematic")
    assert one.keys() == other.keys() and one["left"].keys() == other["left"].keys()
    assert "sat_10" in one["left"]
    for camera, regions in one.items():
        for channel, found in regions.items():
            for region, match in zip(found, other[camera][channel], strict=True):
                assert _flat(region) == pytest.approx(_flat(match), rel=1e-3, abs=1.0)


def _flat(region: Region) -> list[float]:
    return [*region[:4], *region.moments]


def test_unknown_kind_of_cameras_names_the_nearest(dexter: RobotDocument) -> None:
    with pytest.raises(BackendError, match=r"'idael'; did you mean 'ideal'\?.*rendered, ideal"):
        embody("kinematic", dexter, URDF, cameras="idael")


class Eyeless:
    """Backend whose cameras cannot be chosen."""

    def __init__(self, robot: RobotDocument, urdf: Path, gui: bool = False) -> None:
        """Ignore all arguments."""

    reset = observe = apply = step = halt = close = lambda self: None


def test_backend_without_a_choice_says_so(
    monkeypatch: pytest.MonkeyPatch, dexter: RobotDocument
) -> None:
    monkeypatch.setattr(BACKENDS, "_loaded", {})
    monkeypatch.setitem(BACKENDS._builtins, "own", f"{__name__}:Eyeless")
    assert isinstance(embody("own", dexter, URDF), Eyeless)
    with pytest.raises(BackendError, match="'own' offers no choice of cameras"):
        embody("own", dexter, URDF, cameras="ideal")


def test_learned_documents_name_their_cameras(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    out = tmp_path / "seen.yaml"
    words = ["cb", "learn", "searchtrack", "--out", str(out), "--episodes", "1"]
    monkeypatch.setattr("sys.argv", [*words, "--backend", "bullet", "--cameras", "ideal"])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    told = Library(tmp_path).read(out, PolicyDocument).document.provenance
    assert told is not None
    assert (told.backend, told.renderer) == ("bullet", "ideal cameras")
    assert told.command.endswith("--backend bullet --cameras ideal")


def test_make_cameras_without_opengl_takes_ideal_ones_only_without_a_choice(
    dexter: RobotDocument, urdf: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(model: object) -> None:
        raise BackendError("no EGL")

    monkeypatch.setattr(opengl, "OpenGLRenderer", fail)
    model = read_urdf(urdf)
    assert make_cameras(None, dexter, model).renderer == "ideal cameras, since OpenGL is missing"
    with pytest.raises(BackendError, match="libegl1"):
        make_cameras("rendered", dexter, model)
    asked = dexter.model_copy(
        update={"vision": dexter.vision.model_copy(update={"renderer": "opengl"})}
    )
    with pytest.raises(BackendError, match="libegl1"):
        make_cameras(None, asked, model)
