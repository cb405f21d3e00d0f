"""Pictures of knowledge as SVG: policies, schemas and catalogs, as ``cb show`` draws them."""

from __future__ import annotations

from cbdsl.documents.schema import SchemaDocument
from cbdsl.reporting.drawing.catalog_icon import Layer, catalog_icon
from cbdsl.reporting.drawing.policy_graph import policy_graph
from cbdsl.reporting.drawing.policy_transitions import (
    ABOVE,
    PolicyTransitions,
    policy_transitions,
)
from cbdsl.reporting.drawing.schema_graph import schema_graph
from cbdsl.reporting.drawing.svg import svg

__all__ = [
    "ABOVE",
    "Layer",
    "PolicyTransitions",
    "catalog_icon",
    "draw_policy",
    "draw_schema",
    "policy_transitions",
]


def draw_policy(policy: PolicyTransitions) -> str:
    """Return the transition diagram of a policy as the text of an SVG file."""
    return svg(policy_graph(policy))


def draw_schema(schema: SchemaDocument) -> str:
    """Return the trees of a schema as the text of an SVG file."""
    return svg(schema_graph(schema))
