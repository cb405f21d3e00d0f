"""Registries: the named things of one kind, built in or added by other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module, invalidate_caches
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from cbdsl.errors.errors import UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Entry = TypeVar("Entry")


class PluginError(UsageError):
    """A plug-in cannot be imported or breaks its contract; the message says how."""


class Registry(Generic[Entry]):
    """Named entries of one kind, imported when they are asked for.

    Package metadata are read only for a name that is not built in, or to list every entry. A faulty
    plug-in is reported by ``faults``, and raises where it is asked for; all others stay usable.

    Args:
        noun: name of one entry in messages, such as ``backend``.
        group: entry point group by which packages add entries, such as ``cbdsl.backends``.
        builtins: where each built-in entry is, ``module:attribute`` by name.
        validate: entry of a name from the object that was imported; raises PluginError for one
            that breaks the contract.
    """

    def __init__(
        self,
        noun: str,
        group: str,
        builtins: Mapping[str, str],
        validate: Callable[[str, Any], Entry],
    ) -> None:
        self.noun, self.group = noun, group
        self._builtins, self._validate = dict(builtins), validate
        self._loaded: dict[str, Entry] = {}
        self._faulty: dict[str, PluginError] = {}
        self._offers: dict[str, list[EntryPoint]] | None = None

    def __contains__(self, name: object) -> bool:
        """Whether a name is built in or offered by a package, faulty or not."""
        return name in self._builtins or name in self._plugins()

    def names(self) -> tuple[str, ...]:
        """Names of all entries, built-in ones first; those of faulty plug-ins too."""
        return (*self._builtins, *self._plugins())

    def usable_names(self) -> tuple[str, ...]:
        """Names of the entries that are built in, and of the plug-ins that can be used."""
        self.faults()
        return tuple(name for name in self.names() if name not in self._faulty)

    def get(self, name: str) -> Entry:
        """Entry of a name.

        Raises:
            UsageError: nothing has this name; the nearest one and all known ones are named.
            PluginError: a plug-in has it that cannot be used.
            ImportError: a built-in entry needs a package that is not installed.
        """
        if name in self._faulty:
            raise self._faulty[name]
        if name not in self._loaded:
            self._loaded[name] = self._load(name)
        return self._loaded[name]

    def all(self) -> dict[str, Entry]:
        """Entries that can be used, by name, in the order of ``names``."""
        usable = {}
        for name in self.names():
            try:
                usable[name] = self.get(name)
            except PluginError:  # told by ``faults``
                continue
        return usable

    def faults(self) -> tuple[PluginError, ...]:
        """Plug-ins that cannot be used, each with its name, group, package and fault."""
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
        """Those of the faulty plug-ins that were asked for so far; none is imported for it."""
        return tuple(self._faulty.values())

    def package(self, name: str) -> str:
        """Distribution and version that an entry comes from, ``cbdsl`` for a built-in one."""
        return "cbdsl" if self.is_builtin(name) else " ".join(self.distribution(name))

    def distribution(self, name: str) -> tuple[str, str]:
        """Distribution that a plug-in comes from, and its version."""
        return _distribution(self._plugins()[name][0])

    def is_builtin(self, name: str) -> bool:
        """Whether an entry is cbdsl's own."""
        return name in self._builtins

    def name_of(self, entry: object) -> str | None:
        """Return the name under which an entry was asked for, if it was."""
        return next((name for name, loaded in self._loaded.items() if loaded is entry), None)

    @property
    def builtins(self) -> tuple[str, ...]:
        """Names of the entries of cbdsl's own."""
        return tuple(self._builtins)

    def fault(self, name: str, reason: str) -> PluginError:
        """Fault of a plug-in, with its name, group and package."""
        return self._fault(self._plugins()[name][0], reason)

    def refresh(self) -> None:
        """Forget all entries and packages, after ``sys.path`` changed."""
        invalidate_caches()
        self._loaded, self._faulty, self._offers = {}, {}, None

    def _load(self, name: str) -> Entry:
        if name in self._builtins:
            module, _, attribute = self._builtins[name].partition(":")
            return self._validate(name, getattr(import_module(module), attribute))
        if name not in self._plugins():
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
        # Whatever it does at its import, it is the plug-in's fault and nobody else's.
        except (Exception, SystemExit) as error:
            reason = f"cannot be loaded: {type(error).__name__}: {error}"
            raise self._fault(point, reason) from error

    def _fault(self, point: EntryPoint, reason: str) -> PluginError:
        package = f"package {_package(point)}, group {self.group}"
        return PluginError(f"{self.noun} '{point.name}' ({package}): {reason}")

    def _plugins(self) -> dict[str, list[EntryPoint]]:
        """Offers of other packages, by name, in alphabetical order."""
        offered = self._offered()
        return {name: offered[name] for name in sorted(offered) if name not in self._builtins}

    def _offered(self) -> dict[str, list[EntryPoint]]:
        if self._offers is None:
            from importlib.metadata import entry_points  # takes a fifteenth of cb validate's time

            self._offers = {}
            for point in entry_points(group=self.group):
                self._offers.setdefault(point.name, []).append(point)
        return self._offers


def _distribution(point: EntryPoint) -> tuple[str, str]:
    return (point.dist.name, point.dist.version) if point.dist else ("unknown", "unknown")


def _package(point: EntryPoint) -> str:
    return " ".join(_distribution(point))
