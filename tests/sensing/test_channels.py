"""Division of images into channels of hue, saturation, intensity and motion."""

from collections import Counter

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.documents.robot import Channels
from cbdsl.robot.channel_names import channel_names
from cbdsl.robot.channel_spans import channels_of_color
from cbdsl.sensing.channels import GRID, MOST_REGIONS, ChannelFilter, connected_regions

GREY = 190


def picture(color: tuple[int, int, int], rows: slice, columns: slice) -> np.ndarray:
    image = np.full((120, 160, 3), GREY, np.uint8)
    image[rows, columns] = color
    return image


def see(image: np.ndarray, *wanted: str) -> dict:
    return dict(ChannelFilter(Channels(), wanted, 12).regions(image))


def test_channel_names_are_four_colours_ten_bins_of_each_and_motion() -> None:
    names = list(channel_names(Channels()))
    assert len(names) == 35
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
    assert found["sat_10"][0].area == 400
    assert (found["sat_10"][0].column, found["sat_10"][0].row) == pytest.approx((40, 50))
    assert not found["sat_10"][0].clipped


@pytest.mark.parametrize("count", [1, 3, 10, 16])
@given(pixel=st.tuples(*[st.integers(0, 255)] * 3))
def test_bins_of_hue_hold_every_colored_pixel_once(count: int, pixel: tuple[int, int, int]) -> None:
    channels = Channels(hue=count, saturation=count, intensity=count)
    names = channels_of_color([part / 255 for part in pixel], channels)
    by_kind = Counter(name.split("_")[0] for name in names if "_" in name)
    assert by_kind["int"] == 1 and by_kind["sat"] <= 1 and by_kind["hue"] <= by_kind["sat"]
    lit = max(pixel) >= 255 * channels.least_intensity
    colored = max(pixel) - min(pixel) > 0.31 * max(pixel)
    assert by_kind["sat"] == lit and (not (lit and colored) or by_kind["hue"] == 1)


@given(pixel=st.tuples(*[st.integers(0, 255)] * 3))
def test_channels_of_a_color_equal_those_of_its_image(pixel: tuple[int, int, int]) -> None:
    names = [name for name in channel_names(Channels()) if name != "motion"]
    image = np.full((4, 4, 3), pixel, np.uint8)
    seen = ChannelFilter(Channels(), names, 1).regions(image)
    assert set(seen) == {*channels_of_color([part / 255 for part in pixel], Channels())}


def test_region_at_the_border_is_clipped_and_a_speck_is_none() -> None:
    assert see(picture((255, 0, 0), slice(0, 20), slice(30, 50)), "sat_10")["sat_10"][0].clipped
    assert not see(picture((255, 0, 0), slice(40, 43), slice(30, 33)), "sat_10")


@given(
    axes=st.tuples(st.integers(4, 40), st.integers(4, 40)),
    turn=st.floats(0, 180),
    centre=st.tuples(st.integers(50, 110), st.integers(50, 70)),
)
def test_moments_are_those_of_the_pixels_squares(
    axes: tuple[int, int], turn: float, centre: tuple[int, int]
) -> None:
    mask = np.zeros((120, 160), np.uint8)
    cv2.ellipse(mask, centre, axes, turn, 0, 360, 255, -1)
    (region,) = connected_regions(mask, 1)
    # Each pixel as 8 by 8 points.
    rows, columns = np.nonzero(np.kron(mask, np.ones((8, 8), np.uint8)))
    spread = np.cov(columns / 8, rows / 8)
    wanted = (spread[0, 0], spread[0, 1], spread[1, 1])
    assert region.moments == pytest.approx(wanted, rel=1e-3, abs=1e-2)


def test_regions_come_by_size_and_no_more_than_the_most() -> None:
    image = picture((255, 0, 0), slice(40, 60), slice(30, 50))
    for number in range(8):
        size = 5 + number
        image[80 : 80 + size, 15 * number : 15 * number + size] = (255, 0, 0)
    areas = [region.area for region in see(image, "sat_10")["sat_10"]]
    assert areas == [400, *((5 + number) ** 2 for number in (7, 6, 5, 4, 3))]
    assert len(areas) == MOST_REGIONS


def test_motion_is_the_change_since_the_last_image() -> None:
    channel = ChannelFilter(Channels(), ["motion"], 12)
    still = picture((90, 90, 90), slice(40, 60), slice(30, 50))
    assert channel.regions(still) == {}
    assert channel.regions(still) == {}
    moved = channel.regions(picture((90, 90, 90), slice(40, 60), slice(60, 80)))
    assert moved["motion"][0].area == 400


@pytest.mark.parametrize("seed", range(8))
def test_regions_are_those_of_the_whole_image(seed: int) -> None:
    """Label only the bounding box of all regions, at every place in the image."""
    rng = np.random.default_rng(seed)
    mask = np.zeros((60, 80), np.uint8)
    for _ in range(3):
        centre = int(rng.integers(80)), int(rng.integers(60))
        cv2.circle(mask, centre, int(rng.integers(2, 9)), 255, -1)
    count, labels = cv2.connectedComponents(mask, connectivity=8)
    expected = []
    for label in range(1, count):
        rows, columns = np.nonzero(labels == label)
        at_border = {0, 59}.intersection(rows) or {0, 79}.intersection(columns)
        place = float(columns.mean()) + 0.5, float(rows.mean()) + 0.5
        expected.append((len(rows), *place, bool(at_border)))
    seen = [region[:4] for region in connected_regions(mask, 1)]
    for region, right in zip(sorted(seen), sorted(expected), strict=True):
        assert region == pytest.approx(right)


def barcode() -> np.ndarray:
    """Return a white side with bars that leave specks of white, in one piece with it."""
    mask = np.zeros((120, 160), np.uint8)
    mask[20:100, 30:130] = 255
    mask[40:80, 50:110] = 0
    mask[50:70:6, 60:100:9] = 255
    return mask


def test_specks_between_bars_are_a_part_of_the_side() -> None:
    mask = barcode()
    (region,) = connected_regions(mask, 1)
    rows, columns = np.nonzero(mask)
    assert region.area == len(rows)
    assert (region.column, region.row) == pytest.approx((columns.mean() + 0.5, rows.mean() + 0.5))
    assert region.moments.columns == pytest.approx(columns.var() + 1 / 12)


def test_outer_or_large_region_is_no_fragment() -> None:
    mask = barcode()
    mask[5, 5] = 255  # out of it
    mask[50:62, 60:80] = 255  # a twentieth of it
    inner, speck = connected_regions(mask, 1)[1:]
    assert inner.area >= 12 * 20 and speck.area == 1


def test_notch_encloses_nothing() -> None:
    mask = barcode()
    mask[40:80, 110:130] = 0
    assert len(connected_regions(mask, 1)) > 2


@given(
    axes=st.tuples(st.integers(60, 120), st.integers(60, 120)),
    turn=st.floats(0, 180),
    centre=st.tuples(st.integers(30, 60), st.integers(30, 60)),
)
def test_extent_covers_all_inner_pixels(
    axes: tuple[int, int], turn: float, centre: tuple[int, int]
) -> None:
    """Include, for a region cut off by the border, all pixels of a grid with room around them."""
    mask = np.zeros((120, 160), np.uint8)
    cv2.ellipse(mask, centre, axes, turn, 0, 360, 255, -1)
    (region,) = connected_regions(mask, 1)
    assert region.clipped and region.extent is not None
    room, wanted = GRID // 2, set()
    padded = np.pad(mask, room, constant_values=255)  # beyond the image it may go on
    for row in range(room, 120, GRID):
        for column in range(room, 160, GRID):
            if padded[row : row + GRID + 1, column : column + GRID + 1].all():
                wanted.add((column + 0.5, row + 0.5))
    assert wanted == set(region.extent.cover)
    outline = np.array(region.extent.outline)
    assert mask[tuple((outline.reshape(-1, 2)[:, ::-1] - 0.5).astype(int).T)].all()
