import numpy as np
import pytest

from cbdsl.documents.robot import Channels
from cbdsl.robot.channel_names import channel_names
from cbdsl.sensing.channels import ChannelFilter, bin_mask

GREY = 190


def picture(color: tuple[int, int, int], rows: slice, columns: slice) -> np.ndarray:
    image = np.full((120, 160, 3), GREY, np.uint8)
    image[rows, columns] = color
    return image


def see(image: np.ndarray, *wanted: str) -> dict:
    return dict(ChannelFilter(Channels(), wanted, 12).regions(image))


def test_ten_bins_of_each_and_motion() -> None:
    names = list(channel_names(Channels()))
    assert len(names) == 31
    assert {"hue_1", "hue_10", "sat_10", "int_1", "motion"} <= set(names)


@pytest.mark.parametrize(
    ("color", "hue"),
    [
        ((255, 0, 0), "hue_1"),
        ((255, 0, 12), "hue_1"),
        ((255, 255, 0), "hue_3"),
        ((0, 255, 0), "hue_4"),
        ((0, 0, 255), "hue_8"),
    ],
)
def test_pure_colours_have_their_hue_and_full_saturation(
    color: tuple[int, int, int], hue: str
) -> None:
    found = see(picture(color, slice(40, 60), slice(30, 50)), *channel_names(Channels()))
    assert {name for name in found if name.startswith("hue")} == {hue}
    assert found["sat_10"].area == 400
    assert (found["sat_10"].column, found["sat_10"].row) == pytest.approx((40, 50))
    assert not found["sat_10"].clipped


@pytest.mark.parametrize("count", [1, 3, 10, 16])
def test_bins_are_disjoint_complete_and_equal(count: int) -> None:
    values = np.arange(256, dtype=np.uint8)[None]
    masks = np.array([bin_mask(values, index, count) for index in range(count)]) > 0
    assert (masks.sum(axis=0) == 1).all()
    widths = masks.sum(axis=(1, 2))
    assert widths.max() - widths.min() <= 1


def test_a_region_at_the_border_is_clipped_and_a_speck_is_none() -> None:
    assert see(picture((255, 0, 0), slice(0, 20), slice(30, 50)), "sat_10")["sat_10"].clipped
    assert not see(picture((255, 0, 0), slice(40, 43), slice(30, 33)), "sat_10")


def test_of_two_regions_the_larger_is_seen() -> None:
    image = picture((255, 0, 0), slice(40, 60), slice(30, 50))
    image[80:90, 100:110] = (255, 0, 0)
    assert see(image, "sat_10")["sat_10"].area == 400


def test_motion_is_what_changed_since_the_image_before() -> None:
    channel = ChannelFilter(Channels(), ["motion"], 12)
    still = picture((90, 90, 90), slice(40, 60), slice(30, 50))
    assert channel.regions(still) == {}
    assert channel.regions(still) == {}
    moved = channel.regions(picture((90, 90, 90), slice(40, 60), slice(60, 80)))
    assert moved["motion"].area == 400
