"""Pictures of knowledge as SVG: policies, schemas and catalogs, as ``cb show`` draws them."""

from __future__ import annotations

from cbdsl.documents.schema import SchemaDocument
from cbdsl.reporting.drawing.catalog_icon import Layer, catalog_icon
from cbdsl.reporting.drawing.meta_catalog_graph import meta_catalog_graph, pair_key, stack_key
from cbdsl.reporting.drawing.pictogram import LETTERS
from cbdsl.reporting.drawing.policy_graph import percent, policy_graph
from cbdsl.reporting.drawing.policy_transitions import (
    ABOVE,
    Decision,
    PolicyTransitions,
    decisions,
    policy_transitions,
    require_legible,
)
from cbdsl.reporting.drawing.schema_graph import schema_graph
from cbdsl.reporting.drawing.svg import svg

__all__ = [
    "ABOVE", "LETTERS", "Decision", "Layer", "PolicyTransitions", "catalog_icon", "decisions",
    "draw_policy", "draw_schema", "meta_catalog_graph", "pair_key", "percent", "policy_graph",
    "policy_transitions", "require_legible", "stack_key", "svg",
]  # fmt: skip


def draw_policy(policy: PolicyTransitions) -> str:
    """Return the transition diagram of a policy as the text of an SVG file."""
    return svg(policy_graph(policy))


def draw_schema(schema: SchemaDocument) -> str:
    """Return the trees of a schema as the text of an SVG file."""
    return svg(schema_graph(schema))
