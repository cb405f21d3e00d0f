"""Registries: named entries of one kind, built in or added by other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module, invalidate_caches
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Entry = TypeVar("Entry")


class PluginError(UsageError):
    """Error of a plug-in that cannot be imported or breaks its contract; see its message."""


class Registry(Generic[Entry]):
    """Named entries of one kind, imported on request.

    Package metadata are read only for a name that is not built in, or to list every entry. A faulty
    plug-in is reported by ``faults``, and raises on request; all others stay usable.

    Args:
        noun: Noun for one entry in messages, such as ``backend``.
        group: Entry point group by which packages add entries, such as ``cbdsl.backends``.
        builtins: Places of the built-in entries, ``module:attribute`` by name.
        validate: Function that returns the entry from its name and the imported object; raises
            PluginError for an object that breaks the contract.
        made: Built-in entries that need no import, by name.
        providers: Requirement to install, such as ``cbdsl[ros2]``, by the name of an entry that
            another distribution of this project adds.
    """

    def __init__(
        self,
        noun: str,
        group: str,
        builtins: Mapping[str, str],
        validate: Callable[[str, Any], Entry],
        made: Mapping[str, Entry] | None = None,
        providers: Mapping[str, str] | None = None,
    ) -> None:
        self.noun, self.group = noun, group
        self._providers = dict(providers or {})
        self._made, self._validate = dict(made or {}), validate
        # An entry without an import has no place; its name is still reserved against packages.
        self._builtins = {**dict.fromkeys(self._made, ""), **builtins}
        self._loaded: dict[str, Entry] = {}
        self._faulty: dict[str, PluginError] = {}
        self._offers: dict[str, list[EntryPoint]] | None = None

    def __contains__(self, name: object) -> bool:
        """Return whether a name is built in or offered by a package, faulty or not."""
        return name in self._builtins or name in self._plugins()

    def names(self) -> tuple[str, ...]:
        """Return the names of all entries, built-in ones first, including faulty plug-ins."""
        return (*self._builtins, *self._plugins())

    def missing(self) -> dict[str, str]:
        """Return the message of each entry whose distribution is not installed, by name."""
        return {
            name: f"{self.noun} '{name}' comes with {provider}, which is not installed: "
            f"pip install '{provider}'"
            for name, provider in self._providers.items()
            if name not in self
        }

    def usable_names(self) -> tuple[str, ...]:
        """Return the names of the built-in entries and of the usable plug-ins."""
        self.faults()
        return tuple(name for name in self.names() if name not in self._faulty)

    def get(self, name: str) -> Entry:
        """Return the entry of a name.

        Raises:
            UsageError: The name is unknown; the message lists the nearest and all known names. Or
                its distribution is not installed; the message names it.
            PluginError: The plug-in of this name cannot be used.
            ImportError: A built-in entry needs a package that is not installed.
        """
        # The first error is kept, so that a faulty plug-in is not imported at each request.
        if name in self._faulty:
            raise self._faulty[name]
        if name not in self._loaded:
            self._loaded[name] = self._load(name)
        return self._loaded[name]

    def all(self) -> dict[str, Entry]:
        """Return the usable entries by name, in the order of ``names``."""
        usable = {}
        for name in self.names():
            try:
                usable[name] = self.get(name)
            except PluginError:  # reported by ``faults``
                continue
        return usable

    def faults(self) -> tuple[PluginError, ...]:
        """Return the errors of unusable plug-ins, with name, group, package and fault."""
        faults = [
            self._fault(point, "this name is built in")
            for name, points in self._offered().items()
            for point in points
            if name in self._builtins and point.value != self._builtins[name]
        ]
        for name in self._plugins():
            try:
                self.get(name)
            except PluginError as error:
                faults.append(error)
        return tuple(faults)

    @property
    def met_faults(self) -> tuple[PluginError, ...]:
        """Errors of the faulty plug-ins requested so far; reading it imports no plug-in."""
        return tuple(self._faulty.values())

    def package(self, name: str) -> str:
        """Return the distribution and version of an entry, ``cbdsl`` for a built-in one."""
        return "cbdsl" if self.is_builtin(name) else " ".join(self.distribution(name))

    def distribution(self, name: str) -> tuple[str, str]:
        """Return the distribution of a plug-in, and its version."""
        return _distribution(self._plugins()[name][0])

    def is_builtin(self, name: str) -> bool:
        """Return whether an entry is built in."""
        return name in self._builtins

    def name_of(self, entry: object) -> str | None:
        """Return the name under which an entry was requested, or ``None``."""
        return next((name for name, loaded in self._loaded.items() if loaded is entry), None)

    @property
    def builtins(self) -> tuple[str, ...]:
        """Names of the built-in entries."""
        return tuple(self._builtins)

    def fault(self, name: str, reason: str) -> PluginError:
        """Return the error of a plug-in, with its name, group and package."""
        return self._fault(self._plugins()[name][0], reason)

    def refresh(self) -> None:
        """Forget all entries and packages, after ``sys.path`` changed."""
        # The import system caches the contents of folders, and would miss a new package.
        invalidate_caches()
        self._loaded, self._faulty, self._offers = {}, {}, None

    def _load(self, name: str) -> Entry:
        if name in self._made:
            return self._made[name]
        if name in self._builtins:
            module, _, attribute = self._builtins[name].partition(":")
            return self._validate(name, getattr(import_module(module), attribute))
        if name not in self._plugins():
            if message := self.missing().get(name):
                raise UsageError(message)
            raise UsageError.unknown(self.noun, name, self.names())
        try:
            return self._load_plugin(name)
        except PluginError as error:
            self._faulty[name] = error
            raise

    def _load_plugin(self, name: str) -> Entry:
        point, *others = self._plugins()[name]
        if others:
            packages = ", ".join(_package(other) for other in others)
            raise self._fault(point, f"the same name comes from package {packages}")
        try:
            return self._validate(name, point.load())
        except PluginError as error:
            raise self._fault(point, str(error)) from error
        # Any exception at the import of a plug-in is a fault of the plug-in.
        except (Exception, SystemExit) as error:
            reason = f"cannot be loaded: {type(error).__name__}: {error}"
            raise self._fault(point, reason) from error

    def _fault(self, point: EntryPoint, reason: str) -> PluginError:
        package = f"package {_package(point)}, group {self.group}"
        return PluginError(f"{self.noun} '{point.name}' ({package}): {reason}")

    def _plugins(self) -> dict[str, list[EntryPoint]]:
        """Return the entry points of other packages, by name, in alphabetical order."""
        # Entry points come in the order of the search path. Sorting makes messages equal
        # everywhere.
        offered = self._offered()
        return {name: offered[name] for name in sorted(offered) if name not in self._builtins}

    def _offered(self) -> dict[str, list[EntryPoint]]:
        if self._offers is None:
            from importlib.metadata import entry_points  # takes a fifteenth of cb validate's time

            self._offers = {}
            for point in entry_points(group=self.group):
                self._offers.setdefault(point.name, []).append(point)
        return self._offers


def require_function(_: str, entry: Any) -> Any:
    """Return an entry that is a function, for the registries of functions."""
    if not callable(entry):
        raise PluginError(f"is a {type(entry).__name__}, and no function")
    return entry


def _distribution(point: EntryPoint) -> tuple[str, str]:
    return (point.dist.name, point.dist.version) if point.dist else ("unknown", "unknown")


def _package(point: EntryPoint) -> str:
    return " ".join(_distribution(point))
