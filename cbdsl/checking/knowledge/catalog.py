"""Checks of catalog documents against their robot and the programs of their actions."""

from __future__ import annotations

import numpy as np

from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.documents.catalog import AffordanceSection, CatalogDocument, SampleModel
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.pair_names import pair_resource
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.source_map import SourceMap, Step

# Possible error of an element rounded to nine digits, as a share of the largest element.
_ROUNDING = 5e-9


def examine_catalog(
    loaded: Loaded[CatalogDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that a catalog's programs exist and its models are Gaussians of its robot's signals."""
    if loaded.diagnostics:
        return  # a model with missing parts cannot be checked
    document, source, library = loaded.document, loaded.source, session.library
    path = find_document(RobotDocument, document.robot, source.place("robot"), library, diagnostics)
    body = session.body(path, diagnostics)
    for index, name in enumerate(document.over):
        place = source.place("over", index)
        find_document(CatalogDocument, name, place, library, diagnostics, own=document.name)
    for name, affordance in document.affordances.items():
        check_affordance(loaded, ("affordances", name), affordance, session, body, diagnostics)


def check_affordance(
    loaded: Loaded[CatalogDocument] | Loaded[MetaCatalogDocument],
    steps: tuple[Step, ...],
    affordance: AffordanceSection,
    session: Session,
    body: Outcome[CheckedRobot],
    diagnostics: Diagnostics,
) -> None:
    """Check the data of one action: its program, its signals and its models.

    Args:
        loaded: Document with the action.
        steps: Path of the action.
        affordance: Data of the action.
        session: Session that finds programs.
        body: Robot.
        diagnostics: Diagnostics so far.
    """
    _check_program(loaded.source, steps, affordance, session, diagnostics)
    if not isinstance(body, Unknown):
        _check_signals(loaded, steps, affordance, body, diagnostics)
    for key, model in (
        ("with_reward", affordance.with_reward),
        ("without_reward", affordance.without_reward),
    ):
        if model is not None:
            _check_model(loaded.source, (*steps, key), affordance, model, diagnostics)


def _check_program(
    source: SourceMap,
    steps: tuple[Step, ...],
    affordance: AffordanceSection,
    session: Session,
    diagnostics: Diagnostics,
) -> None:
    """Check that the program of an action exists and has the given parameters."""
    place = source.place(*steps, "program")
    path = find_document(ProgramDocument, affordance.program, place, session.library, diagnostics)
    read = session.read(path, ProgramDocument, diagnostics)
    if isinstance(read, Unknown):
        return
    known = read.document.assignable
    for key in affordance.with_:
        if key not in known:
            at = source.key(*steps, "with", key)
            diagnostics.add("CB606", at, names=list(known), name=key, program=affordance.program)


def _check_signals(
    loaded: Loaded[CatalogDocument] | Loaded[MetaCatalogDocument],
    at: tuple[Step, ...],
    affordance: AffordanceSection,
    body: CheckedRobot,
    diagnostics: Diagnostics,
) -> None:
    """Check that the features are signals of the robot with matching units and sizes."""
    for key, feature in affordance.features.items():
        steps = (*at, "features", key)
        named = body.resources
        resource = named.get(feature.signal) or pair_resource(feature.signal, named)
        if resource is None:
            names, robot = list(named), loaded.document.robot
            place = loaded.source.place(*steps, "signal")
            diagnostics.add("CB654", place, names=names, name=feature.signal, robot=robot)
            continue
        wanted, given = (resource.type.size, resource.type.unit), (feature.components, feature.unit)
        if wanted != given:
            place = loaded.source.place(*steps, "unit")
            details = {"wanted": _described(*wanted), "found": _described(*given)}
            diagnostics.add("CB652", place, signal=feature.signal, **details)


def _described(size: int, unit: str) -> str:
    return f"{count(size, 'component')} in {unit or 'no unit'}"


def _check_model(
    source: SourceMap,
    steps: tuple[Step, ...],
    affordance: AffordanceSection,
    model: SampleModel,
    diagnostics: Diagnostics,
) -> None:
    """Check that a model has the features' components and a valid covariance."""
    wanted = sum(feature.components for feature in affordance.features.values())
    if wanted != len(model.mean):
        details = {"wanted": count(wanted, "component"), "found": f"{len(model.mean)}"}
        diagnostics.add("CB653", source.place(*steps, "mean"), **details)
        return
    # A covariance is symmetric without negative eigenvalues, up to the rounding of the document. By
    # Weyl's inequality, an error E moves an eigenvalue by at most its norm. This norm is at most n
    # max |E_ij| for n components.
    covariance = np.array(model.covariance)
    bound = _ROUNDING * len(covariance) * max(float(np.abs(covariance).max()), 1e-12)
    fault = ""
    if np.abs(covariance - covariance.T).max() > bound:
        fault = "symmetric"
    elif np.linalg.eigvalsh(covariance).min() < -bound:
        fault = "positive"
    if fault:
        place = source.place(*steps, "covariance")
        diagnostics.add("CB651", place, what=f"'{steps[-2]}' {steps[-1]}", fault=fault)
