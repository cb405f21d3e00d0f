"""``cb show catalog``: an object's affordances as text, as data, as an icon, or as predictions."""

from __future__ import annotations

from difflib import unified_diff
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.api.reading.clean import require_clean
from cbdsl.api.simulation.expect import expect
from cbdsl.cli.arguments.options import BackendName, Cameras, Seed
from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.cli.output.terminal import print_json
from cbdsl.cli.show.formats import PICTURED, Format, Json, read_format
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.reporting.drawing.catalog_icon import Layer, catalog_icon
from cbdsl.reporting.text.catalog_text import catalog_text
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from cbdsl.training.held_out import Prediction

Catalog = Annotated[str, typer.Argument(metavar="FILE|NAME", help="Catalog: file or name.")]
Against = Annotated[
    str | None,
    typer.Option("--against", metavar="FILE|NAME", help="Another catalog to compare with."),
]
Expect = Annotated[
    str | None,
    typer.Option(
        "--expect",
        metavar="STAGE",
        help="Stage on which to predict rewards and test the predictions: file or name.",
    ),
]
Scenes = Annotated[int, typer.Option("--scenes", min=1, help="With --expect: number of scenes.")]
FormatOption = Annotated[
    str, typer.Option("--format", help="Output format: text or json; svg for the icon.")
]
Icon = Annotated[bool, typer.Option("--svg", help="Short for --format svg.")]


def show_catalog(
    name: Catalog,
    *,
    against: Against = None,
    on: Expect = None,
    scenes: Scenes = 20,
    seed: Seed = 1_000_000,
    backend: BackendName,
    cameras: Cameras = None,
    format_: FormatOption = "text",
    svg: Icon = False,
    as_json: Json = False,
) -> None:
    """Show the affordances of an object with their counts and the certainty of their models.

    --against prints the lines that differ from another catalog. With --expect, the robot observes
    scenes of a stage, predicts the reward of each action, and tries one action in each.
    """
    if on is not None and against is not None:
        raise UsageError("--expect predicts and --against compares: choose one")
    form = read_format("svg" if svg else format_, as_json, PICTURED)
    if on is not None:
        _predict(name, on, scenes, seed, backend, cameras, form is Format.JSON)
        return
    catalog = _read(name)
    if against is not None:
        print(_difference(_read(against), catalog), end="")
    elif form is Format.SVG:
        print(_icon(catalog), end="")
    elif form is Format.JSON:
        print_json(catalog.model_dump(mode="json", by_alias=True, exclude_none=True))
    else:
        print(catalog_text(catalog), end="")


def _read(name: str) -> CatalogDocument:
    library = Library()
    file = library.locate(CatalogDocument, name)
    require_clean(file, library)
    return library.read(file, CatalogDocument).document


def _difference(other: CatalogDocument, catalog: CatalogDocument) -> str:
    before, after = (catalog_text(each).splitlines() for each in (other, catalog))
    # The first three lines are the names of two files and their line numbers, which texts do not
    # have.
    lines = list(unified_diff(before, after, lineterm="", n=len(before) + len(after)))[3:]
    return "\n".join(lines or ["no difference"]) + "\n"


def _icon(catalog: CatalogDocument) -> str:
    layers = [Layer(key, e.tried, e.rewarded) for key, e in catalog.affordances.items()]
    return catalog_icon(catalog.name, catalog.feature, layers)


def _predict(
    name: str, stage: str, scenes: int, seed: int, backend: str, cameras: str | None, as_json: bool
) -> None:
    def tell(prediction: Prediction) -> None:
        if not as_json:
            word = "rewarded" if prediction.rewarded else "no reward"
            print(
                f"scene {prediction.scene + 1} of {scenes}: {prediction.action:20s} "
                f"{chance(prediction)}  {word}",
                flush=True,
            )

    with needing_simulation():
        from cbdsl.cli.output.compilation import told_of_compilation

        with told_of_compilation():
            predictions = expect(
                name, stage, seed=seed, scenes=scenes, backend=backend, cameras=cameras,
                on_prediction=tell,
            )  # fmt: skip
    _conclude(predictions, as_json=as_json)


def chance(prediction: Prediction) -> str:
    """Return a predicted probability as text."""
    return f"{prediction.probability:.2f}" if prediction.known else "unknown"


def _conclude(predictions: list[Prediction], *, as_json: bool) -> None:
    from cbdsl.training.held_out import brier, reliability

    own, base, rows = brier(predictions), brier(predictions, base=True), reliability(predictions)
    if as_json:
        print_json(
            {
                "predictions": [each._asdict() for each in predictions],
                "brier": own,
                "base_rates": base,
                "reliability": [each._asdict() for each in rows],
            }
        )
        return
    print(f"\nBrier score {own:.4f}; of the base rates {base:.4f}")
    for row in rows:
        print(
            f"  predicted {row.low:.1f} to {row.high:.1f}: {row.number} times, "
            f"mean {row.predicted:.2f}, rewarded {row.rewarded:.2f}"
        )
