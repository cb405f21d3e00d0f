"""Graph of a meta-catalog: objects, and the pairs that were tried (Figures 7.10 and 7.17)."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import networkx as nx

if TYPE_CHECKING:
    from cbdsl.documents.meta_catalog import MetaCatalogDocument, PairSection

    ThingGraph = nx.MultiDiGraph[str]
    SupportGraph = nx.DiGraph[str]


def thing_graph(catalog: MetaCatalogDocument) -> ThingGraph:
    """Return a meta-catalog as a graph, with its provenance.

    Returns:
        Objects by name, each with its ``feature`` and, if present, its ``catalog``. Pairs are edges
        from the lower object to the upper one, by relation. An edge holds its ``pair``, the counts
        ``tried`` and ``rewarded``, and the ``probability`` that it stays. Attributes of the graph
        are ``name``, ``robot``, and, if known, ``command``, ``stage``, ``seed``, ``actions``.
    """
    graph: ThingGraph = nx.MultiDiGraph(name=catalog.name, robot=catalog.robot)
    if (origin := catalog.provenance) is not None:
        graph.graph.update(
            command=origin.command,
            stage=origin.stage.name,
            seed=origin.seed,
            actions=origin.actions,
        )
    for name, thing in catalog.things.items():
        known = {} if thing.catalog is None else {"catalog": thing.catalog}
        graph.add_node(name, feature=thing.feature, **known)
    for name, pair in catalog.pairs.items():
        graph.add_edge(
            pair.lower,
            pair.upper,
            key=pair.relation,
            pair=name,
            tried=pair.tried,
            rewarded=pair.rewarded,
            probability=_probability(pair),
        )
    return graph


def support_graph(
    catalog: MetaCatalogDocument, things: Collection[str] | None = None
) -> SupportGraph:
    """Return the graph with an edge from each object to each one that stayed on it at least once.

    Args:
        catalog: Catalog of pairs.
        things: Names of the present objects [all known ones].
    """
    known = thing_graph(catalog)
    chosen = known if things is None else known.subgraph(things)
    support: SupportGraph = nx.DiGraph()
    support.add_nodes_from(chosen)
    support.add_edges_from(
        (lower, upper, facts)
        for lower, upper, relation, facts in chosen.edges(keys=True, data=True)
        if relation == "on" and facts["rewarded"]
    )
    return support


def _probability(pair: PairSection) -> float:
    """Return the probability that a pair stays, by Laplace's rule; 0 if it never did."""
    return (pair.rewarded + 1) / (pair.tried + 2) if pair.rewarded else 0.0
