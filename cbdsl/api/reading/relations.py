"""Relations documents without errors, and their trees."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from cbdsl.documents.relations import RelationsDocument
    from cbdsl.learning.impedance import ImpedanceProfile
    from cbdsl.types.decision_tree import Tree
    from cbdsl.yaml_text.library import Library
    from cbdsl.yaml_text.loaded import Loaded


def read_relations(name: str, library: Library) -> Loaded[RelationsDocument]:
    """Return relations without errors, by their name or file.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such document.
    """
    from cbdsl.api.reading.clean import require_clean
    from cbdsl.documents.relations import RelationsDocument

    file = library.locate(RelationsDocument, name)
    require_clean(file, library)
    return library.read(file, RelationsDocument)


def read_relation_tree(name: str, library: Library) -> Tree[str]:
    """Return the tree of relations without errors, by their name or file.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such document.
    """
    from cbdsl.checking.knowledge.relations import relation_tree
    from cbdsl.diagnostics.diagnostics import Diagnostics

    # The document is without errors, so that its diagnostics need no reader.
    return relation_tree(read_relations(name, library), Diagnostics())


def read_namer(name: str) -> Callable[[ImpedanceProfile], str | None]:
    """Return the function that names profiles by shipped relations.

    Raises:
        DiagnosticsError: The document has errors.
        UsageError: There is no such document.
    """
    from cbdsl.learning.catalogs.relation_tree import name_relation
    from cbdsl.yaml_text.library import Library, shipped

    # Documents of the same name in the working folder do not count here.
    tree = read_relation_tree(name, Library(shipped()))
    return lambda profile: name_relation(tree, profile)
