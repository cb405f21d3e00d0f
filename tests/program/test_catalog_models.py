"""Probabilities of reward as resources, and as conditions of schemas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.program import examine_program
from cbdsl.checking.schema import checked_schema
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.affordance_model import deviation_of
from cbdsl.program.catalog_models import models_of
from cbdsl.program.checked import CheckedProgram
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library
from tests.backends.conftest import stage_named

# Rewarded within the table's length, and never beyond it.
CATALOG = """\
cbdsl: 1
kind: catalog
name: ball
robot: dexter
feature: sat_10
affordances:
  reachtouch:
    program: reachtouch
    tried: 80
    rewarded: 60
    features: {place: {signal: stereo.sat_10, unit: m, components: 3}}
    with_reward:
      count: 60
      mean: [0.6, -0.2, -0.36]
      covariance: &spread [[0.01, 0, 0], [0, 0.02, 0], [0, 0, 0.0001]]
    without_reward: {count: 20, mean: [1.2, -0.2, -0.36], covariance: *spread}
"""
SCHEMA = """\
cbdsl: 1
kind: schema
name: sure
program: reachtouch
policy: reachtouch
catalog: ball
features: {sure: affords.reachtouch}
allocations:
  right: {arm: right_arm, hand: right_hand}
  left: {arm: left_arm, hand: left_hand}
choose: {if: sure > 0.5, then: right, else: left}
otherwise: [left]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {"catalogs/ball": CATALOG, "schemas/sure": SCHEMA}.items():
        path = tmp_path / "knowledge" / f"{name}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def checked(folder: Path) -> CheckedProgram:
    library, diagnostics = Library(folder), Diagnostics()
    session = Session(library)
    loaded = library.read(library.locate(SchemaDocument, "sure"), SchemaDocument)
    program = checked_schema(
        loaded,
        session,
        diagnostics,
        lambda path, values, own: examine_program(path, values, session, own),
    )
    assert program is not None, diagnostics.sorted()
    return program


def test_affordance_is_a_feature_with_its_probability(folder: Path) -> None:
    schema = checked(folder).schema
    assert schema is not None
    (resource,) = schema.features.values()
    assert (resource.name, resource.type.name) == ("affords.reachtouch", "probability")
    assert [each.name for each in resource.source.features] == ["stereo.sat_10"]  # type: ignore[union-attr]


@pytest.mark.parametrize(("x", "arm"), [(0.55, "right"), (1.2, "left")])
def test_schema_chooses_by_the_probability_of_reward(
    folder: Path, dexter: RobotDocument, urdf: Path, kinematics: Kinematics, x: float, arm: str
) -> None:
    program = checked(folder)._replace(episode_time=4.0)
    plain = stage_named("table_right")
    data = plain.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    shown = data["contexts"]["in_view"]
    shown["place"] |= {"x": [x, x], "y": [-0.2, -0.2]}
    data["fixtures"]["table"]["form"]["size"][0] = [2.0, 2.0]
    stage = type(plain).model_validate(data)
    backend = KinematicBackend(dexter, urdf)
    runner = Runner(dexter, kinematics, program, backend)
    read: list[float] = []

    def note(tick: Tick) -> None:
        assert program.schema is not None
        (resource,) = program.schema.features.values()
        reading = tick.signals.read(resource)
        if reading is not None:
            read.append(float(reading.value[0]))

    transitions: list[str] = []
    observer = EpisodeListeners(lambda each: transitions.append(each.allocation), note)
    runner.run(stage, 3, "in_view", observer)
    assert read and (np.median(read) > 0.9 if arm == "right" else np.median(read) < 0.1)
    assert arm in transitions


@pytest.mark.parametrize(
    ("constants", "deviation", "prior"),
    [({}, deviation_of("m"), 1.0), ({"units": "si", "prior": 4.0}, 1.0, 4.0)],
)
def test_model_has_the_prior_of_its_exploration(
    constants: dict[str, object], deviation: float, prior: float
) -> None:
    identity = {"name": "any", "sha256": "0" * 64}
    provenance = {
        "command": "cb explore",
        "programs": {"reachtouch": identity},
        "robot": identity,
        "stage": identity,
        "algorithm": "explore_catalog",
        "constants": constants,
        "seed": 1,
        "actions": 80,
        "backend": "kinematic",
        "renderer": "ideal",
        "versions": {},
    }
    document = CatalogDocument.model_validate(yaml.safe_load(CATALOG) | {"provenance": provenance})
    model = models_of(document)["reachtouch"]
    assert model.scale.tolist() == [deviation] * 3
    assert model.prior == prior
