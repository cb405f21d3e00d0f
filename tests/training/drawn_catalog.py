"""Synthetic catalogs."""

from __future__ import annotations

from cbdsl.documents.catalog import AffordanceSection, CatalogDocument, StepColumns


def catalog(actions: str, changes: list[float]) -> CatalogDocument:
    """Return a catalog of actions: T rewarded touch, t unrewarded touch, S search, dot NOOP."""
    names = {"T": "reachtouch", "t": "reachtouch", ".": "noop", "S": "searchtrack"}
    tried = {
        name: AffordanceSection(
            program=name,
            tried=sum(names[a] == name for a in actions),
            rewarded=sum(names[a] == name and a.isupper() for a in actions),
        )
        for name in ("reachtouch", "searchtrack")
    }
    largest = max(changes) or 1.0
    return CatalogDocument(
        cbdsl=1,
        kind="catalog",
        name="made",
        robot="dexter",
        feature="red",
        affordances=tried,
        steps=StepColumns(
            action=tuple(names[a] for a in actions),
            rewarded=tuple(a.isupper() for a in actions),
            change=tuple(changes),
            reward=tuple(
                0.0 if a == "." else c / largest - 0.05
                for a, c in zip(actions, changes, strict=True)
            ),
        ),
    )


TEN = catalog("TtTTS.T...", [4.0, 0.0, 2.0, 1.0, 0.5, 0.0, 0.1, 0.0, 0.0, 0.0])
