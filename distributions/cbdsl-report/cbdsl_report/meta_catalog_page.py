"""Page of a meta-catalog: its graph, its pairs, and stacks of the available objects."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from cbdsl.api.documents import AffordanceSection, CatalogProvenance, MetaCatalogDocument
from cbdsl.api.drawing import meta_catalog_graph, pair_key, stack_key
from cbdsl.api.learning import pairs_of, plan_stacks, support_graph
from cbdsl.extend.command import Bundle, count, filled, stack_command
from cbdsl_report.markup import ASSETS, Markup, table, terms

_STYLES = ("page.css", ASSETS / "learned.css", ASSETS / "meta_catalog.css")
_SCRIPTS = ("page.js", "data.js", ASSETS / "meta_catalog.js")
# Maximum height of listed stacks, because their number grows fast with the number of objects.
_HIGHEST = 4


def meta_catalog_page(catalog: MetaCatalogDocument) -> str:
    """Return the page of a meta-catalog; the same document gives the same text."""
    stood = sum(pair.rewarded > 0 for pair in catalog.pairs.values())
    slots = {
        "heading": escape(catalog.name),
        "where": escape(_where(catalog)),
        "verdict": f"{stood} of {len(catalog.pairs)} pairs ever stayed",
        "graph": meta_catalog_graph(catalog),
        "things": "".join(_choice(name) for name in catalog.things),
        "pairs": _pairs(catalog),
        "provenance": "" if catalog.provenance is None else _provenance(catalog.provenance),
    }
    data = Bundle().text({"plans": [*_plans(catalog)]})
    return filled(ASSETS / "meta_catalog.html", catalog.name, _STYLES, _SCRIPTS, data, slots)


def _where(catalog: MetaCatalogDocument) -> str:
    words, origin = f"which things {catalog.robot} brings to which", catalog.provenance
    if origin is None:
        return words
    return f"{words}, after {count(origin.actions, 'action')} on {origin.stage.name}"


def _choice(thing: str) -> str:
    name = escape(thing)
    return f'<label><input type="checkbox" name="thing" value="{name}" checked> {name}</label>'


def _pairs(catalog: MetaCatalogDocument) -> Markup:
    rows = [
        (f"{pair.upper} {pair.relation} {pair.lower}", *_counts(pair), _seen(pair))
        for pair in catalog.pairs.values()
    ]
    headings = ("pair", "stayed", "95 % interval", "upper from lower when it stayed, x, y, z, cm")
    return table("Pairs that were brought together", headings, rows)


def _counts(pair: AffordanceSection) -> tuple[str, str]:
    interval = ""
    if pair.interval is not None:
        interval = f"{100 * pair.interval[0]:.0f} to {100 * pair.interval[1]:.0f} %"
    return f"{pair.rewarded} of {pair.tried}", interval


def _seen(pair: AffordanceSection) -> str:
    """Return the mean of the offset in its model, cm; empty if it has none."""
    place = 0
    for name, feature in pair.features.items():
        if name == "offset" and pair.with_reward is not None:
            own = pair.with_reward.mean[place : place + feature.components]
            return ", ".join(f"{100 * value:.1f}" for value in own)
        place += feature.components
    return ""


def _provenance(origin: CatalogProvenance) -> Markup:
    return terms(
        {
            "command": Markup(f"<code>{escape(origin.command)}</code>"),
            "stage": origin.stage.name,
            "robot": origin.robot.name,
            "programs": ", ".join(origin.programs),
            "policies": ", ".join(origin.policies),
            "algorithm": origin.algorithm,
            "seed": origin.seed,
            "engine": origin.backend,
        }
    )


def _plans(catalog: MetaCatalogDocument) -> Iterator[dict[str, object]]:
    """Yield all stacks that follow from the pairs, the surest of each height first."""
    support = support_graph(catalog)
    for height in range(2, min(_HIGHEST, len(catalog.things)) + 1):
        for plan in plan_stacks(support, height):
            yield {
                "order": list(plan.order),
                "probability": plan.probability,
                "command": stack_command([catalog.things[name].feature for name in plan.order]),
                "boxes": [
                    *plan.order,
                    *map(pair_key, pairs_of(support, plan.order)),
                    stack_key(plan.order),
                ],
            }
