"""``cb report``: learned documents as a page; ``cb playground``: a program on a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cbdsl.extend.command import (
    Above,
    Open,
    UsageError,
    open_page,
    require_room,
    write_page,
)

What = Annotated[
    Path,
    typer.Argument(
        metavar="FILE|FOLDER",
        help="Policy of cb learn, a folder of several trials, or a meta-catalog of cb explore.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="File of the page [beside FILE, .html; FOLDER/report.html]."),
]
Program = Annotated[str, typer.Argument(help="Program to begin with: file or name.")]
Port = Annotated[
    int, typer.Option("--live-port", min=0, max=65535, help="Port of the page [a free one].")
]


def report(what: What, out: Out = None, above: Above = 0.2, open_: Open = True) -> None:
    """Write a self-contained page of learned documents.

    The page of policies has learning curves over all trials, and the policy, internal models and
    episodes of each trial. The page of a meta-catalog has its graph, its pairs, and stacks that can
    be planned.

    Exit 0 if the page was written, 1 if a document has errors, 2 if the page cannot be made.
    """
    try:
        from cbdsl.api.documents import MetaCatalogDocument
        from cbdsl.extend.command import read_meta_catalog
        from cbdsl.extend.document import is_of
        from cbdsl_report.learned_files import find_learned, read_learned
        from cbdsl_report.learned_page import learned_page
        from cbdsl_report.meta_catalog_page import meta_catalog_page
    except ModuleNotFoundError as error:
        raise UsageError(
            f"a report needs {error.name}, which is not installed: pip install 'cbdsl[sim]'"
        ) from error
    files = find_learned(what)
    target = out or (what / "report.html" if what.is_dir() else what.with_suffix(".html"))
    if any(target.resolve() == file.resolve() for file in files):
        raise UsageError(f"--out {target}: this is a document, which a page would overwrite")
    require_room(target, follow=out is not None)
    if is_of(MetaCatalogDocument, files[0]):
        text = meta_catalog_page(read_meta_catalog(str(files[0])))
    else:
        text = learned_page([read_learned(file) for file in files], above)
    write_page(text, target, follow=out is not None)
    if open_:
        open_page(target)


def playground(program: Program = "let_go", port: Port = 0, open_: Open = True) -> None:
    """Show a page on which a program is edited, checked, drawn and run, until Ctrl-C.

    Only browsers of this machine reach the page. Runs use the kinematic backend. The file of the
    program is read, and never written.
    """
    from cbdsl_report.playground import serve_playground

    serve_playground(program, port, opens=open_)
