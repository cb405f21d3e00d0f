"""Documents that a program names: its robot, its stage, and internal models."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbdsl.checking.lookup.document_search import find_document, for_robot
from cbdsl.checking.program_context import Steps
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.document import Document
from cbdsl.documents.kind import Kind
from cbdsl.documents.kinds import KINDS, kind_name
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.pair_names import pair_resource
from cbdsl.robot.resources import NOVEL
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.types.resource import LIKENESS_OF, Origin, PairLikeness, Resource
from cbdsl.types.resource_type import LIKENESS
from cbdsl.yaml_text.loaded import Loaded

if TYPE_CHECKING:
    from cbdsl.numeric.affordance_model import AffordanceModel


class _PairModel:
    """Model of a pair of a meta-catalog, computed at its first use.

    Args:
        catalog: Meta-catalog with the pair.
        pair: Name of the pair.
    """

    def __init__(self, catalog: MetaCatalogDocument, pair: str) -> None:
        self._catalog, self._pair = catalog, pair

    def __call__(self) -> AffordanceModel:
        """Return the model."""
        return self._model

    @cached_property
    def _model(self) -> AffordanceModel:
        # Validation needs no model, and starts without numpy.
        from cbdsl.program.catalog_models import model_of

        return model_of(self._catalog.pairs[self._pair], self._catalog)


def likeness_resource(
    catalog: MetaCatalogDocument, pair: str, resources: Mapping[str, Resource]
) -> Resource | None:
    """Return the resource ``likeness.<pair>`` of a pair of a meta-catalog.

    Args:
        catalog: Meta-catalog with the pair.
        pair: Name of the pair.
        resources: Resources of the robot, by name.

    Returns:
        Resource, or ``None`` if the pair never stayed, or the robot lacks a feature of its model.
    """
    own = catalog.pairs[pair]
    signals = [pair_resource(each.signal, resources) for each in own.features.values()]
    features = tuple(each for each in signals if each is not None)
    if own.with_reward is None or not features or len(features) < len(signals):
        return None
    source = PairLikeness(catalog.name, pair, _PairModel(catalog, pair), features)
    return Resource(f"{LIKENESS_OF}{pair}", LIKENESS, Origin.ENVIRONMENT, source)


_KINDS: dict[str, type[Document]] = {
    "stage": StageDocument,
    "use": ProgramDocument,
    "models": ModelDocument,
    "meta_catalog": MetaCatalogDocument,
}


class Dependencies:
    """Search for the documents that one program names.

    Args:
        loaded: Program.
        session: Session with the documents read so far.
        diagnostics: Diagnostics so far.

    Attributes:
        robot: Robot's file.
    """

    def __init__(
        self, loaded: Loaded[ProgramDocument], session: Session, diagnostics: Diagnostics
    ) -> None:
        self._loaded, self._document, self._source = loaded, loaded.document, loaded.source
        self._session, self._diagnostics = session, diagnostics
        self._others: set[str] = set()
        self._models: dict[str, Outcome[tuple[Resource, ...]]] = {}
        self._body: Outcome[CheckedRobot] = UNKNOWN
        # First parts of names that a document with errors would define.
        self._unread: set[str] = set()
        self.robot = self._find_robot()

    def _find_robot(self) -> Outcome[Path]:
        place, library = self._source.place("robot"), self._session.library
        return find_document(RobotDocument, self._document.robot, place, library, self._diagnostics)

    def check_stage(self) -> None:
        """Check that the stage exists, and is for the same robot."""
        name = self._document.stage
        if name is None:
            return
        path = self.find(StageDocument, name, ("stage",))
        stage = self._session.read(path, StageDocument, self._diagnostics)
        if not isinstance(stage, Unknown):
            self.is_for_the_robot(stage.document.robot, name, ("stage",))

    def find(self, kind: type[Document], name: str, steps: Steps) -> Outcome[Path]:
        """Return the file of a document, or propose documents for the robot if there is none."""
        place, library = self._source.place(*steps), self._session.library
        robot = None if self.robot is UNKNOWN else self._document.robot
        own = self._document.name if kind is ProgramDocument else ""
        return find_document(kind, name, place, library, self._diagnostics, robot, own)

    def is_for_the_robot(self, other: str, name: str, steps: Steps) -> bool:
        """Return whether a document is for the program's robot; true if unknown.

        Args:
            other: Robot of the document.
            name: Document's name.
            steps: Path of the reference to it.
        """
        robot, source = self._document.robot, self._source
        if self.robot is UNKNOWN or robot in (other, UNKNOWN) or other in (ANY_ROBOT, UNKNOWN):
            return True
        # Suggest only documents for this robot: any other name would be the same mistake again.
        kind, library = _KINDS[str(steps[0])], self._session.library
        names = for_robot(kind, robot, self._loaded.path, library)
        related = [(source.place("robot"), f"this program is for '{robot}'")]
        details = {"name": name, "other": other, "robot": robot, "given": ""}
        place = source.place(*steps)
        self._diagnostics.add("CB603", place, names=names, related=related, **details)
        self._others.add(other)
        return False

    def is_unknown(self, name: str) -> bool:
        """Return whether a resource is unknown because of an error elsewhere.

        Its internal model may have errors, or the robot's document may lack the first or last part
        of its name. It may also belong to another robot, for which a document named here is.
        """
        first, last = name.partition(".")[0], name.rpartition(".")[2]
        models = self._source.declared(self._models, "models")
        return (
            models.get(last) is UNKNOWN
            or first in self._unread
            or (first == NOVEL and any(each is UNKNOWN for each in self._models.values()))
            or (
                not isinstance(self._body, Unknown)
                and not self._body.missed.isdisjoint((first, last))
            )
            or any(name in self._resources(other) for other in self._others)
        )

    def _resources(self, robot: str) -> Collection[str]:
        path = self._session.library.find(RobotDocument, robot, self._loaded.path)
        body = self._session.body(path or UNKNOWN, Diagnostics())
        return () if isinstance(body, Unknown) else body.resources

    def body(self) -> Outcome[CheckedRobot]:
        """Return the robot with the internal models that the program draws from."""
        body = self._body = self._session.body(self.robot, self._diagnostics)
        if isinstance(body, Unknown):
            return UNKNOWN
        for alias, name in self._document.models.items():
            self._models[alias] = self._model(alias, name, body)
        known = [each for each in self._models.values() if not isinstance(each, Unknown)]
        named = {resource.name: resource for each in known for resource in each}
        named |= self._pairs(body)
        return body._replace(resources={**body.resources, **named}) if named else body

    def _pairs(self, body: CheckedRobot) -> dict[str, Resource]:
        """Return the likenesses to the pairs of the program's meta-catalog that ever stayed."""
        name = self._document.meta_catalog
        if name is None:
            return {}
        path = self.find(MetaCatalogDocument, name, ("meta_catalog",))
        catalog = self._session.read(path, MetaCatalogDocument, self._diagnostics)
        if isinstance(catalog, Unknown):
            self._unread.add(LIKENESS_OF.rstrip("."))
            return {}
        self.is_for_the_robot(catalog.document.robot, name, ("meta_catalog",))
        pairs = catalog.document.pairs
        made = (likeness_resource(catalog.document, pair, body.resources) for pair in pairs)
        return {each.name: each for each in made if each is not None}

    def _lacks_a_package(self) -> bool:
        """Return whether a controller's potential comes with a package that is not installed.

        Its diagnostic names the package, which may also bring kinds of models.
        """
        missing = POTENTIALS.registry.missing() if self._document.models else {}
        controllers = self._document.controllers.values()
        return any(not isinstance(c, str) and c.potential in missing for c in controllers)

    def _model(self, alias: str, name: str, body: CheckedRobot) -> Outcome[tuple[Resource, ...]]:
        steps: Steps = ("models", alias)
        kind = self._session.library.model_kind(name, self._loaded.path)
        if kind is None and self._lacks_a_package():
            return UNKNOWN
        path = self.find(kind.model if kind else ModelDocument, name, steps)
        model = self._session.read(path, kind.model if kind else ModelDocument, self._diagnostics)
        if isinstance(model, Unknown) or kind is None:
            return UNKNOWN
        for key in (key for key, other in kind.references.items() if other == "robot"):
            self.is_for_the_robot(getattr(model.document, key), name, steps)
        resources = _resources_of(kind, alias, model, body, self._diagnostics)
        if isinstance(resources, Unknown):
            return UNKNOWN
        before = [each for each in self._models.values() if not isinstance(each, Unknown)]
        taken = {*body.resources, *(each.name for some in before for each in some)}
        twice = next((each.name for each in resources if each.name in taken), None)
        if twice is not None:
            place = self._source.key(*steps)
            self._diagnostics.add("CB633", place, name=twice, robot=self._document.robot)
        return resources


def _resources_of(
    kind: Kind, alias: str, loaded: Loaded[Any], body: CheckedRobot, diagnostics: Diagnostics
) -> Outcome[tuple[Resource, ...]]:
    """Return the resources that a document gives to a program, by the function of its kind.

    Raises:
        PluginError: The function of another package fails; the message names the package.
    """
    module, _, function = kind.resources.partition(":")
    name = kind_name(kind.model)
    try:
        resources: Outcome[tuple[Resource, ...]] = getattr(import_module(module), function)(
            alias, loaded, body, diagnostics
        )
    except Exception as error:
        if KINDS.is_builtin(name):
            raise
        reason = f"its resources fail on {loaded.path}: {type(error).__name__}: {error}"
        raise KINDS.fault(name, reason) from error
    return resources
