"""Open links of a robot's drivers."""

from __future__ import annotations

from importlib import import_module

from cbdsl.extend.driver import (
    DRIVERS,
    BackendError,
    Driver,
    DriverLink,
    DriverLinkFactory,
    RobotDocument,
    UsageError,
    extra_advice,
)


def open_links(robot: RobotDocument, interface: str | None) -> list[DriverLink]:
    """Open all drivers of a robot, one link for each kind.

    Args:
        robot: Robot with drivers.
        interface: Network interface; loopback only if ``None``.

    Raises:
        BackendError: The robot has no drivers, a kind is unknown or not installed, or a link cannot
            be opened.
    """
    by_kind: dict[str, dict[str, Driver]] = {}
    for name, driver in robot.drivers.items():
        by_kind.setdefault(driver.kind, {})[name] = driver
    links: list[DriverLink] = []
    try:
        links.extend(_factory(kind)(robot, own, interface) for kind, own in by_kind.items())
    # Also at Ctrl-C: an open link would keep its bus or its network participant.
    except BaseException:
        for link in links:
            link.close()
        raise
    return links


def require_drivers(robot: RobotDocument) -> None:
    """Refuse a robot without drivers.

    Raises:
        BackendError: It has none.
    """
    if not robot.drivers:
        raise BackendError(
            f"robot '{robot.name}' has no drivers; its document declares them below 'drivers'"
        )


def _factory(kind: str) -> DriverLinkFactory:
    try:
        module, _, attribute = DRIVERS.get(kind).link.partition(":")
        factory: DriverLinkFactory = getattr(import_module(module), attribute)
    except ImportError as error:
        raise BackendError(
            f"driver kind '{kind}' cannot be loaded: {error}; {extra_advice(kind)}"
        ) from error
    except UsageError as error:
        raise BackendError(str(error)) from error
    return factory
