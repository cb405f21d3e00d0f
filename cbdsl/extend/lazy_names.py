"""Names of modules that are imported when they are first used."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module


def lazy_names(file: str) -> Callable[[str], object]:
    """Return ``__getattr__`` of a module: the names that it imports for type checkers.

    Every command imports the declarations of plug-ins, which may not cost the import of numpy. The
    module's own text says where a name comes from, so that each import is written once.

    Args:
        file: Python file of the module, with ``if TYPE_CHECKING`` around its imports.
    """

    @cache
    def homes() -> dict[str, str]:
        import ast

        with open(file, encoding="utf-8") as stream:
            tree = ast.parse(stream.read())
        guarded = [node for block in tree.body if isinstance(block, ast.If) for node in block.body]
        return {
            alias.name: str(node.module)
            for node in guarded
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }

    def read(name: str) -> object:
        # `import *` and pickle look for names such as `__path__`.
        if name.startswith("__") or name not in homes():
            raise AttributeError(f"{file} has no attribute '{name}'")
        return getattr(import_module(homes()[name]), name)

    return read
