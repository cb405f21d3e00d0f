"""Addresses of a driver, each with its path in the driver's section."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.documents.driver import Driver

_SINGLE = ("states", "commands", "description", "stop")
_BY_CAMERA = ("images", "camera_info", "regions")


def addresses(driver: Driver) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the path and the address of each stream of messages that a driver names."""
    for key in _SINGLE:
        address = getattr(driver, key)
        if address is not None:
            yield (key,), address
    for hand, fingers in driver.wrenches.items():
        yield from ((("wrenches", hand, finger), address) for finger, address in fingers.items())
    for key in _BY_CAMERA:
        yield from (((key, camera), address) for camera, address in getattr(driver, key).items())
