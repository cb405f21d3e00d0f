"""Program with other internal models: same controllers, with samples from other densities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from cbdsl.documents.model import Gaussian, Kernel
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.types.resource import GaussianSample, KernelSample, Origin, Resource, Source


def density_source(effector: str, density: Gaussian | Kernel) -> GaussianSample | KernelSample:
    """Return a source of samples of a density over an effector's configurations."""
    if isinstance(density, Gaussian):
        return GaussianSample(effector, density.mean, density.deviation, density.uniform)
    return KernelSample(effector, density.samples, density.bandwidth, density.uniform)


def internal_models(program: CheckedProgram) -> dict[str, Resource]:
    """Return the internal models from which a program's own actions draw references, by name."""
    models = {}
    for action in program.actions:
        for controller in action.controllers:
            reference = controller.reference
            if isinstance(reference, Resource) and reference.origin is Origin.MODEL:
                models[reference.name] = reference
    return models


def bind(program: CheckedProgram, sources: Mapping[str, Source]) -> CheckedProgram:
    """Return the program with other densities behind some of its internal models.

    The programs that it uses keep their densities.

    Args:
        program: Program to change.
        sources: Replacement sources by the model's name in the program.
    """
    if not sources:
        return program
    primitives = {name: _primitive(each, sources) for name, each in program.primitives.items()}
    actions = tuple(_action(action, sources) for action in program.actions)
    background = program.background and _composition(program.background, sources)
    return program._replace(primitives=primitives, actions=actions, background=background)


def _action(action: Action, sources: Mapping[str, Source]) -> Action:
    if action.composition is None:
        return action
    return action._replace(composition=_composition(action.composition, sources))


def _composition(composition: Composition, sources: Mapping[str, Source]) -> Composition:
    return Composition(tuple(_primitive(each, sources) for each in composition.primitives))


def _primitive(primitive: Primitive, sources: Mapping[str, Source]) -> Primitive:
    controllers = tuple(_controller(each, sources) for each in primitive.controllers)
    return primitive._replace(controllers=controllers)


def _controller(controller: Controller, sources: Mapping[str, Source]) -> Controller:
    reference = controller.reference
    # Constants and perceived positions have no density to replace.
    if not isinstance(reference, Resource) or reference.name not in sources:
        return controller
    return replace(controller, reference=reference._replace(source=sources[reference.name]))
