"""Identification of the kind of a document by its declaration and its keys."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.wording import diagnose
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import KINDS, kind_name, models
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.invalid_value import describe, not_allowed
from cbdsl.yaml_text.source_map import SourceMap

# Fewer keys of another kind are separate mistakes.
_LEAST_EVIDENCE = 2


def identify(
    source: SourceMap, diagnostics: tuple[Diagnostic, ...]
) -> tuple[type[Document], tuple[Diagnostic, ...]]:
    """Return the model of a document's kind, and all diagnostics, including a wrong ``kind``."""
    root = source.root
    if not isinstance(root.value, dict):
        described = describe(root.value)
        fault = diagnose("CB204", root.place, expected="a mapping", found=described)
        raise DiagnosticsError([*diagnostics, fault])
    kind: Node | None = root.value.get("kind")
    if kind is not None and (kind.faulty or any(part.faulty for part in kind.children())):
        raise DiagnosticsError(diagnostics)
    declared = None if kind is None else str(kind.value)
    model = None if declared is None else _model_of(declared)
    suggestion = _contradicted(root.value, declared, model)
    is_right = model is not None and suggestion is None
    wrong = () if is_right else (_wrong_kind(source, declared, model, suggestion),)
    model = _model_of(suggestion) if suggestion else model
    if model is None:
        raise DiagnosticsError([*diagnostics, *wrong])
    place = root.place if kind is None else kind.place
    # The remaining text is validated as a document of the identified kind.
    root.value["kind"] = Node(place, kind_name(model))
    return model, (*diagnostics, *wrong)


def _model_of(kind: str) -> type[Document] | None:
    """Return the model of a kind, or ``None`` if it is unavailable."""
    try:
        return KINDS.get(kind).model
    except UsageError:
        return None


def _contradicted(
    keys: Iterable[str], declared: str | None, model: type[Document] | None
) -> str | None:
    """Return the document kind whose keys match, if it differs from the declared kind."""
    if model is not None and model.model_fields.keys() >= set(keys):
        return None
    return kind_by_keys(keys, declared, models())


def _wrong_kind(
    source: SourceMap, declared: str | None, model: type[Document] | None, suggestion: str | None
) -> Diagnostic:
    """Return the diagnostic of a kind that is missing, unknown or contradicted by the keys."""
    if declared is None:
        names = [suggestion] if suggestion else list(models())
        return diagnose("CB203", source.root.place, names=names, key="kind")
    place = source.place("kind")
    if model is None:
        return not_allowed(place, list(models()), source.node(("kind",)).value)
    assert suggestion is not None, "nothing is wrong with it otherwise"
    keys = ", ".join(telling_keys(source.root.keys, suggestion, declared, models()))
    return diagnose("CB210", place, said=declared, found=suggestion, keys=keys)


# The evidence for a kind is the number of the document's keys that the kind has. Keys of all kinds
# do not count. The number of its required keys that the document lacks is subtracted. Another kind
# is suggested only if it is the single best one and exceeds the declared kind by a margin. If no
# known kind is declared, any evidence is enough.
def kind_by_keys(
    keys: Iterable[str], declared: str | None, kinds: Mapping[str, type[Document]]
) -> str | None:
    """Return the document kind that matches the keys clearly better than the declared kind.

    Args:
        keys: Keys of the document.
        declared: Declared kind, if any.
        kinds: Models by kind.

    Returns:
        Matching kind, or ``None`` if the keys do not contradict the declared kind or are ambiguous.
    """
    given = frozenset(keys)
    evidence = {kind: _evidence(given, model) for kind, model in kinds.items()}
    best = max(evidence, key=lambda kind: evidence[kind])
    least = evidence[declared] + _LEAST_EVIDENCE if declared in evidence else 1
    is_clear = sum(number == evidence[best] for number in evidence.values()) == 1
    return best if is_clear and evidence[best] >= least else None


def telling_keys(
    keys: Iterable[str], kind: str, declared: str | None, kinds: Mapping[str, type[Document]]
) -> list[str]:
    """Return the keys that are valid for one kind of document but not for the declared kind."""
    others = kinds.get(declared or "", Document).model_fields
    return [key for key in keys if key in kinds[kind].model_fields and key not in others]


def _evidence(keys: frozenset[str], model: type[Document]) -> int:
    """Return the number of keys that match a kind, minus its missing required keys."""
    required = {name for name, field in model.model_fields.items() if field.is_required()}
    required |= {key for key, others in model.alternatives.items() if keys.isdisjoint(others)}
    common = Document.model_fields.keys() | {"kind"}
    return len((keys & model.model_fields.keys()) - common) - len(required - keys - common)
