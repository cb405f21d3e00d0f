"""Named colours: red, yellow, green and blue as people use these names."""

from __future__ import annotations

import colorsys

import pytest

from cbdsl.documents.robot import Channels, ColorRange
from cbdsl.robot.channel_names import color_of, named_colors
from cbdsl.robot.channel_spans import channels_of_color

# Names of CSS. Those of the last list are for other colours, also where they name one of the four.
CSS = {
    "red": {
        "red": "ff0000",
        "crimson": "dc143c",
        "darkred": "8b0000",
        "firebrick": "b22222",
        "tomato": "ff6347",
    },
    "yellow": {"yellow": "ffff00", "gold": "ffd700"},
    "green": {
        "green": "008000",
        "lime": "00ff00",
        "chartreuse": "7fff00",
        "darkgreen": "006400",
        "forestgreen": "228b22",
        "lawngreen": "7cfc00",
        "lightgreen": "90ee90",
        "limegreen": "32cd32",
        "olivedrab": "6b8e23",
        "palegreen": "98fb98",
        "seagreen": "2e8b57",
        "springgreen": "00ff7f",
    },
    "blue": {
        "blue": "0000ff",
        "cornflowerblue": "6495ed",
        "darkblue": "00008b",
        "deepskyblue": "00bfff",
        "dodgerblue": "1e90ff",
        "mediumblue": "0000cd",
        "midnightblue": "191970",
        "navy": "000080",
        "royalblue": "4169e1",
        "skyblue": "87ceeb",
        "steelblue": "4682b4",
    },
    "": {
        "beige": "f5f5dc",
        "black": "000000",
        "brown": "a52a2a",
        "burlywood": "deb887",
        "chocolate": "d2691e",
        "cyan": "00ffff",
        "darkgoldenrod": "b8860b",
        "darkorange": "ff8c00",
        "grey": "808080",
        "hotpink": "ff69b4",
        "indigo": "4b0082",
        "khaki": "f0e68c",
        "lavender": "e6e6fa",
        "magenta": "ff00ff",
        "olive": "808000",
        "orange": "ffa500",
        "peru": "cd853f",
        "pink": "ffc0cb",
        "purple": "800080",
        "rosybrown": "bc8f8f",
        "saddlebrown": "8b4513",
        "salmon": "fa8072",
        "sandybrown": "f4a460",
        "sienna": "a0522d",
        "slategray": "708090",
        "tan": "d2b48c",
        "teal": "008080",
        "turquoise": "40e0d0",
        "violet": "ee82ee",
        "white": "ffffff",
    },
}
# Ten shades of each, as hue in degrees, saturation and value.
SHADES = {
    "red": [
        (0, 1, 1), (0, 1, 0.8), (0, 0.8, 1), (0, 0.75, 0.8), (5, 0.9, 0.7),
        (355, 0.9, 0.9), (350, 1, 0.6), (8, 0.95, 0.95), (358, 0.7, 0.8), (0, 0.9, 0.5),
    ],
    "yellow": [
        (60, 1, 1), (60, 1, 0.8), (60, 0.8, 1), (55, 1, 0.9), (50, 1, 1),
        (52, 0.9, 0.95), (62, 0.7, 0.9), (48, 1, 1), (58, 0.6, 1), (66, 0.9, 0.95),
    ],
    "green": [
        (120, 1, 1), (120, 1, 0.8), (120, 1, 0.4), (120, 0.6, 0.8), (100, 0.9, 0.7),
        (90, 1, 0.8), (140, 0.8, 0.6), (150, 1, 0.9), (112, 0.67, 0.6), (130, 0.5, 0.5),
    ],
    "blue": [
        (240, 1, 1), (240, 1, 0.8), (240, 1, 0.4), (240, 0.7, 0.9), (216, 1, 1),
        (210, 0.8, 0.9), (200, 0.9, 0.9), (225, 0.6, 0.7), (235, 0.9, 0.5), (250, 0.9, 0.9),
    ],
}  # fmt: skip
# Tables, wood, leather and cardboard.
BROWNS = [
    (0.6, 0.45, 0.3), (0.65, 0.5, 0.35), (0.55, 0.35, 0.2), (0.4, 0.26, 0.13), (0.5, 0.4, 0.1),
    (0.35, 0.15, 0.1), (0.76, 0.6, 0.42), (0.59, 0.29, 0.0), (0.7, 0.55, 0.2), (0.45, 0.2, 0.1),
]  # fmt: skip
NAMES = set(CSS) - {""}


def names_of(color: tuple[float, ...]) -> set[str]:
    return NAMES.intersection(channels_of_color(color, Channels()))


@pytest.mark.parametrize("name", CSS)
def test_css_colours_go_by_the_name_that_people_give_them(name: str) -> None:
    for css, digits in CSS[name].items():
        color = tuple(int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
        assert names_of(color) == ({name} if name else set()), css


@pytest.mark.parametrize("name", SHADES)
def test_shades_go_by_one_name_in_light_and_in_shade(name: str) -> None:
    for hue, saturation, value in SHADES[name]:
        for light in (1.0, 0.85):
            color = colorsys.hsv_to_rgb(hue / 360, saturation, light * value)
            # A surface in shade may be too dark for its name, and never has another name.
            assert names_of(color) <= {name}
            assert light < 1 or names_of(color), (hue, saturation, value)


@pytest.mark.parametrize("color", BROWNS)
def test_brown_is_none_of_the_named_colours(color: tuple[float, ...]) -> None:
    assert names_of(color) == set()


def test_alias_or_declared_colour_takes_the_place_of_a_usual_colour() -> None:
    orange = (ColorRange(hue=(0.3, 0.7)),)
    assert named_colors(Channels(colors={"orange": orange}))["orange"] == orange
    assert named_colors(Channels(colors={"red": orange}))["red"] == orange
    assert "red" not in named_colors(Channels(aliases={"red": "hue_1"}))


@pytest.mark.parametrize(
    ("channel", "color"),
    [("hue_1", "red"), ("hue_2", "hue_2"), ("hue_7", "blue"), ("blue", "blue"), ("sat_9", "sat_9")],
)
def test_bin_of_hue_is_of_the_colour_that_contains_its_middle(channel: str, color: str) -> None:
    assert color_of(channel, Channels()) == color
