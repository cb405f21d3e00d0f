"""A potential, a sensor and a modifier of another package: declared, checked, run and listed."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument, Sensor
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.robot.source_kind import SOURCES
from cbdsl.sensing.observation import Observation
from cbdsl.sensing.signals import Signals
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.registry import PluginError
from docs.make_reference import page
from tests.cli.test_main import cb
from tests.conftest import ROOT
from tests.plugins.installed import write_package

HEAD = "cbdsl: 1\nkind: program\nname: own\nrobot: dexter\nstage: table_right\n"
OWN = """controllers:
  out:
    {potential: keep_out, reference: right_arm.position, feedback: left_arm.position,
     effector: left_arm, gain: 2 /s, quiescence: {rate: 1e-4, window: 0.3 s}}
  circle:
    {potential: spring, reference: [0.35 m, -0.3 m, 0.1 m], feedback: right_arm.position,
     effector: right_arm.position, modifiers: {orbit: {radius: 5 cm, period: 4 s}}}
actions: [circle, out, circle ◁ out]
policy: {"**": circle ◁ out}
limits: {transitions: 40, transition_time: 6 s}
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.yaml").write_text(HEAD + OWN, "utf-8")
    return tmp_path


def recorded(folder: Path) -> dict[str, np.ndarray]:
    (file,) = folder.glob("*.npz")
    with np.load(file) as arrays:
        return dict(arrays)


def test_program_with_plugin_potential_sensor_and_modifier_runs(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "validate", "own.yaml") == 0
    words = ("run", "own.yaml", "--backend", "kinematic", "--record", "kept")
    assert cb(monkeypatch, *words) in (0, 1)
    palm = recorded(here / "kept")["signal_right_arm.position"]
    centre = np.array([0.35, -0.3, 0.1])
    rest = palm[len(palm) // 2 :] - centre
    assert np.linalg.norm(rest[:, :2], axis=1) == pytest.approx(0.05, abs=0.02)
    assert np.ptp(np.unwrap(np.arctan2(rest[:, 1], rest[:, 0]))) > 1.0
    assert abs(rest[:, 2]).max() < 0.02


def test_modifier_of_the_slot_changes_how_a_controller_moves(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Move a hand with a quarter of gain and speed at most a quarter as fast."""
    reach = OWN.split("  circle:")[0].split("  out:")[0] + (
        "  go: {potential: spring, reference: [0.35 m, -0.3 m, 0.1 m], feedback: "
        "right_arm.position,\n       effector: right_arm, gain: 2 /s, speed: 0.2 m/s%s}\n"
        'actions: [go]\npolicy: {"*": go}\nlimits: {transitions: 2, transition_time: 3 s}\n'
    )
    fastest = []
    for number, modifier in enumerate(("", ", modifiers: {calm: {share: 0.25}}")):
        (here / "own.yaml").write_text(HEAD + reach % modifier, "utf-8")
        kept = f"kept_{number}"
        words = ("run", "own.yaml", "--backend", "kinematic", "--record", kept)
        assert cb(monkeypatch, *words) in (0, 1)
        palm = recorded(here / kept)["signal_right_arm.position"]
        fastest.append(np.linalg.norm(np.diff(palm, axis=0), axis=1).max())
    assert fastest[1] == pytest.approx(0.25 * fastest[0], rel=0.1)


def test_modifier_of_the_slot_that_fails_is_named(
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    module = (
        "from demo.calm import CALM\n"
        "HASTE = CALM._replace(name='haste', slot='bad_modifier:bind')\n"
        "def bind(form, options, setting):\n    return None\n"
    )
    write_package(
        folder, "bad", {"cbdsl.modifiers": {"haste": "bad_modifier:HASTE"}}, bad_modifier=module
    )
    MODIFIERS.refresh()
    circle = OWN.replace("orbit: {radius: 5 cm, period: 4 s}", "haste: {share: 2}")
    (here / "own.yaml").write_text(HEAD + circle, "utf-8")
    assert cb(monkeypatch, "run", "own.yaml", "--backend", "kinematic") == 2
    told = capsys.readouterr().err
    assert "haste" in told and "bad 1.0" in told and "not a SlotForm" in told


@pytest.mark.parametrize(
    ("given", "wanted", "told"),
    [
        ("keep_out", "keep_oot", "keep_out"),
        ("orbit: {radius: 5 cm, period: 4 s}", "funnel: {height: 5 cm}", "a key of the controller"),
        ("orbit: {radius", "orbt: {radius", "unknown modifier 'orbt'"),
        ("period: 4 s", "period: 4 cm", "expected time"),
        (", period: 4 s", "", "its options are radius, period"),
        ("[0.35 m, -0.3 m, 0.1 m], feedback: right_arm.position,\n     effector: "
         "right_arm.position",
         "0, feedback: right_arm,\n     effector: right_arm", "references of type position"),
    ],
)  # fmt: skip
def test_wrong_options_of_plugins_are_diagnostics(
    here: Path,
    given: str,
    wanted: str,
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (here / "own.yaml").write_text(HEAD + OWN.replace(given, wanted), "utf-8")
    assert cb(monkeypatch, "validate", "own.yaml") == 1
    assert told in capsys.readouterr().out


@pytest.mark.parametrize(
    ("what", "name"),
    [
        ("potentials", "keep_out"),
        ("sources", "wrist_force_torque"),
        ("modifiers", "orbit"),
        ("modifiers", "calm"),
        ("modifiers", "funnel"),
    ],
)
def test_plugin_potential_sensor_and_modifier_are_listed(
    what: str, name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", what, "--json") == 0
    assert name in [next(iter(row.values())) for row in json.loads(capsys.readouterr().out)]


def test_reference_has_the_potential() -> None:
    assert "`keep_out`" in page()


def test_sensor_is_read(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (here / "robots").mkdir()
    for file in (ROOT / "robots").glob("dexter.*"):
        shutil.copy(file, here / "robots")
    robot = here / "robots" / "dexter.yaml"
    sensor = "\nsensors:\n  wrist: {kind: wrist_force_torque, link: right_palm, hand: right_hand}\n"
    robot.write_text(robot.read_text("utf-8") + sensor, "utf-8")
    program = (ROOT / "programs" / "tactileprobe.yaml").read_text("utf-8")
    watched = (
        "  yield:\n    {potential: spring, reference: [0 N, 0 N, 0 N], feedback: wrist.force,\n"
    )
    watched += "     effector: right_arm}\n"
    (here / "own.yaml").write_text(
        program.replace("name: tactileprobe", "name: own")
        .replace(
            "roles: {hand: effector of force}", "robot: dexter\nparameters: {hand: right_hand}"
        )
        .replace("stages: [cube_on_bench]\n", "")
        .replace("$hand.touch", "2 N")
        .replace("$hand.probe", "0.6 rad/s")
        .replace("controllers:\n", "controllers:\n" + watched)
        .replace("actions: [", "actions: [yield, ", 1)
        .replace('"**":', '"***":'),
        "utf-8",
    )
    assert cb(monkeypatch, "validate", "own.yaml") == 0
    words = (
        "run",
        "own.yaml",
        "--backend",
        "kinematic",
        "--stage",
        "held_right",
        "--record",
        "kept",
    )
    assert cb(monkeypatch, *words) in (0, 1)
    arrays = recorded(here / "kept")
    force, loads = arrays["signal_wrist.force"], arrays["loads"]
    felt = np.isfinite(force).all(axis=1)
    assert felt.any() and not felt.all()
    assert force[felt] == pytest.approx(
        (loads - loads[0])[:, :3, :3].sum(axis=1)[felt], abs=1e-9
    ) or force[felt] == pytest.approx((loads - loads[0])[:, 3:, :3].sum(axis=1)[felt], abs=1e-9)


FAULTY = {
    "of a wrong name": ("POTENTIAL = KEEP_OUT", "calls itself 'keep_out'"),
    "without claims": ("POTENTIAL = 3", "is a int, not a PotentialType"),
    "of no type": (
        "POTENTIAL = KEEP_OUT._replace(name='faulty', accepts=frozenset({'smell'}))",
        "accepts smell",
    ),
    "that raises": ("raise RuntimeError('no licence')", "no licence"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_faulty_plugin_potential_does_not_affect_others(
    fault: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text, told = FAULTY[fault]
    module = f"from demo.keep_out import KEEP_OUT\n{text}\n"
    write_package(folder, "bad", {"cbdsl.potentials": {"faulty": "bad_potential:POTENTIAL"}},
                  bad_potential=module)  # fmt: skip
    POTENTIALS.registry.refresh()
    assert cb(monkeypatch, "show", "potentials") == 0
    shown = capsys.readouterr()
    assert told in shown.err and "bad 1.0" in shown.err and "keep_out" in shown.out


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("residual[7] = 0.0\n    return 0.0", "IndexError"),
        ("return 1", "not a float"),
        ("if value[0] > -9.0:\n        raise ValueError('broken')\n    return 0.0", "broken"),
    ],
)
def test_potential_that_breaks_its_contract_is_named_before_anything_moves(
    body: str,
    told: str,
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    module = (
        "from cbdsl.control.potential import Potential, potential\n"
        "from demo.keep_out import KEEP_OUT\n"
        "POTENTIAL = KEEP_OUT._replace(name='faulty', implementation='bad_kernel:build')\n"
        "def build(controller, setting):\n    return Potential(wrong, 1)\n"
        f"@potential\ndef wrong(value, reference, parameters, residual, slope):\n    {body}\n"
    )
    write_package(folder, "bad", {"cbdsl.potentials": {"faulty": "bad_kernel:POTENTIAL"}},
                  bad_kernel=module)  # fmt: skip
    POTENTIALS.registry.refresh()
    (here / "own.yaml").write_text(HEAD + OWN.replace("keep_out", "faulty"), "utf-8")
    assert cb(monkeypatch, "run", "own.yaml", "--backend", "kinematic") == 2
    error = capsys.readouterr().err
    assert told in error and "faulty" in error and "bad 1.0" in error and "Traceback" not in error


def test_potential_that_raises_while_it_runs_is_named(
    here: Path,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    # Its value is 0.1 everywhere in the trial call.
    module = (
        "from cbdsl.control.potential import Potential, potential\n"
        "from demo.keep_out import KEEP_OUT\n"
        "POTENTIAL = KEEP_OUT._replace(name='faulty', implementation='late_kernel:build')\n"
        "def build(controller, setting):\n    return Potential(wrong, 1)\n"
        "@potential\ndef wrong(value, reference, parameters, residual, slope):\n"
        "    if value[0] != 0.1:\n        raise ValueError('too late')\n    return 0.0\n"
    )
    points = {"cbdsl.potentials": {"faulty": "late_kernel:POTENTIAL"}}
    write_package(folder, "bad", points, late_kernel=module)
    POTENTIALS.registry.refresh()
    (here / "own.yaml").write_text(HEAD + OWN.replace("keep_out", "faulty"), "utf-8")
    assert cb(monkeypatch, "run", "own.yaml", "--backend", "kinematic") == 2
    error = capsys.readouterr().err
    assert "too late" in error and "bad 1.0" in error and "internal error" not in error


@pytest.mark.parametrize(
    ("given", "wanted", "told"),
    [
        ("Reading(value, robot", "Reading(value[:2], robot", "its value has shape (2,), not (3,)"),
        ("jacobian[:3], signals", "jacobian[:2], signals", "its Jacobian has shape (2, "),
        ("return read", "raise OSError('unplugged')", "unplugged"),
    ],
)
def test_sensor_that_breaks_its_contract_is_named(
    given: str, wanted: str, told: str, folder: Path, dexter: RobotDocument, kinematics: Kinematics
) -> None:
    text = (Path(__file__).parent / "package/demo/wrist.py").read_text("utf-8")
    assert given in text
    text = text.replace(given, wanted).replace("wrist_force_torque", "bad_wrist")
    points = {"cbdsl.sources": {"bad_wrist": "bad_wrist:WRIST"}}
    write_package(folder, "bad", points, bad_wrist=text.replace("demo.wrist", "bad_wrist"))
    SOURCES.refresh()
    sensor = Sensor(kind="bad_wrist", link="right_palm", hand="right_hand")
    robot = dexter.model_copy(update={"sensors": {"wrist": sensor}})
    signals = Signals(robot, kinematics, ())
    cells = [(hand, finger) for hand, own in robot.load_cells.items() for finger in own]
    still = np.zeros(len(kinematics.joints))
    with pytest.raises(PluginError, match=re.escape(told)) as raised:
        force = resources(robot)["wrist.force"]
        for load in (0.0, 5.0):
            loads = {cell: np.full(6, load) for cell in cells}
            signals.update(Observation(0.0, still, still, loads, {}))
            signals.read(force)
    assert "bad 1.0" in str(raised.value)
