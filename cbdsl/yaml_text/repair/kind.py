"""Which kind of document a text is, by what it says and by its keys."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from cbdsl.documents.document import Document

# Fewer keys of another kind are mistakes of their own.
_LEAST_EVIDENCE = 2


def kind_by_keys(
    keys: Iterable[str], said: str | None, kinds: Mapping[str, type[Document]]
) -> str | None:
    """The kind that the keys of a document are those of, instead of the one that it says.

    Args:
        keys: of the document.
        said: the kind that it says it is.
        kinds: models by kind.

    Returns:
        ``None`` where the keys do not contradict it, or tell nothing.
    """
    given = frozenset(keys)
    evidence = {kind: _evidence(given, model) for kind, model in kinds.items()}
    best = max(evidence, key=lambda kind: evidence[kind])
    least = evidence.get(said, 0) if said is not None else 0
    is_clear = sum(found == evidence[best] for found in evidence.values()) == 1
    return best if is_clear and evidence[best] >= least + _LEAST_EVIDENCE else None


def telling_keys(
    keys: Iterable[str], kind: str, said: str | None, kinds: Mapping[str, type[Document]]
) -> list[str]:
    """The keys that documents of one kind have, and those of another do not."""
    others = kinds.get(said or "", Document).model_fields
    return [key for key in keys if key in kinds[kind].model_fields and key not in others]


def _evidence(keys: frozenset[str], model: type[Document]) -> int:
    """How many keys are of a kind of document, less those that it would have and are missing."""
    fields = model.model_fields.items()
    missing = sum(field.is_required() and name not in keys for name, field in fields)
    return len(keys & model.model_fields.keys()) - missing
