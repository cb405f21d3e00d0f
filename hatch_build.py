"""Addresses in the metadata of a release, which depend on the repository that publishes it.

``CBDSL_REPOSITORY`` names it as OWNER/NAME of GitHub. A build without it states no address, so that
no copy names the site of others. Commands and the build of the site read them from the metadata.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_LINK = re.compile(r"\]\((?!https?://|#)([^)#]+)")
# Folder of the documentation, whose files are pages of the site, and assets beside them.
_DOCS = "docs/"


class Addresses(MetadataHookInterface):
    """Addresses of the project, and its README with links that work elsewhere."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add them to the metadata of the project."""
        text = (Path(self.root) / "README.md").read_text("utf-8")
        repository = os.environ.get("CBDSL_REPOSITORY", "")
        if repository:
            owner, _, name = repository.partition("/")
            source, site = f"https://github.com/{repository}", f"https://{owner}.github.io/{name}/"
            pages = f"{site}{metadata['version']}/"
            metadata["urls"] = {"Homepage": site, "Documentation": pages, "Source": source}
            files = f"{source}/blob/v{metadata['version']}/"
            text = _LINK.sub(lambda link: f"]({_address(link[1], pages, files)}", text)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}


def _address(path: str, pages: str, files: str) -> str:
    """Return the address of a file of the repository."""
    if not path.startswith(_DOCS):
        return files + path
    return pages + re.sub(r"\.md$", ".html", path.removeprefix(_DOCS))
