"""``cb report``: learned documents as a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.cli.options import Above, Open
from cbdsl.cli.pages import open_page, require_room, write_page

What = Annotated[
    Path,
    typer.Argument(
        metavar="FILE|FOLDER",
        help="Policy of cb learn, a folder of several trials, or a meta-catalog of cb explore.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="The page's file [beside FILE, .html; FOLDER/report.html]."),
]


def report(what: What, out: Out = None, above: Above = 0.2, open_: Open = True) -> None:
    """Make one self-contained page of learned documents.

    Learning curves over all trials, and each trial's policy, internal models and episodes. Of a
    meta-catalog its graph, its pairs, and the stacks that can be planned of the things that are
    there.

    Exit 0 when the page was written, 1 when a document has errors, 2 when it could not be made.
    """
    from cbdsl.cli.show_meta_catalog import read_meta_catalog
    from cbdsl.documents.meta_catalog import MetaCatalogDocument
    from cbdsl.errors.errors import UsageError
    from cbdsl.yaml_text.library import is_of

    try:
        from cbdsl.reporting.learned import find_learned, read_learned
        from cbdsl.reporting.learned_page import learned_page
        from cbdsl.reporting.meta_catalog_page import meta_catalog_page
    except ModuleNotFoundError as error:
        raise UsageError(
            f"a report needs {error.name}, which is not installed: pip install 'cbdsl[sim]'"
        ) from error
    files = find_learned(what)
    target = out or (what / "report.html" if what.is_dir() else what.with_suffix(".html"))
    if any(target.resolve() == file.resolve() for file in files):
        raise UsageError(f"--out {target}: this is a document, which a page would overwrite")
    require_room(target)
    if is_of(MetaCatalogDocument, files[0]):
        text = meta_catalog_page(read_meta_catalog(str(files[0])))
    else:
        text = learned_page([read_learned(file) for file in files], above)
    write_page(text, target)
    if open_:
        open_page(target)
