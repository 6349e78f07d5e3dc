"""Colours: all eyes tell UAVs apart, text can be read, and pages take their colours from the palette."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from skyverse.draw import palette

VISION = {
    "full": np.eye(3),
    "no red cones": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no green cones": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "no blue cones": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}
"""What eyes make of linear red, green and blue: G. M. Machado et al., IEEE Trans. Vis. Comput. Graph. 15(6), 2009."""


def linear(tone):
    """Linear red, green and blue of an sRGB colour."""
    part = np.array(list(bytes.fromhex(tone[1:7]))) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """CIELAB of linear red, green and blue, under D65."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    share = to_xyz @ np.clip(rgb, 0, 1) / (0.9505, 1.0, 1.089)
    x, y, z = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast(one, other):
    """The contrast of WCAG 2, from 1 to 21."""
    dark, light = sorted((0.2126, 0.7152, 0.0722) @ linear(tone) for tone in (one, other))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("eyes", VISION)
def test_all_eyes_tell_the_colours_of_uavs_apart(eyes):
    seen = [lab(np.array(VISION[eyes]) @ linear(tone)) for tone in palette.TRACKS]
    assert min(np.linalg.norm(one - other) for one, other in combinations(seen, 2)) > 10  # a difference of 2 is seen


@pytest.mark.parametrize("theme", [palette.LIGHT, palette.DARK])
def test_text_stands_out_from_its_ground(theme):
    pairs = [(text, ground) for text in ("ink", "soft", "accent") for ground in ("ground", "card")]
    pairs += [("accent", "press"), *((tone, f"{tone}-ground") for tone in ("good", "warn", "bad"))]
    pairs += [("ink", f"{tone}-ground") for tone in ("good", "warn", "bad")]
    for text, ground in pairs:
        assert contrast(theme[text], theme[ground]) >= 4.5, (text, ground)


def test_a_dark_page_has_the_names_of_a_light_one():
    assert palette.DARK.keys() == palette.LIGHT.keys()


def test_pages_have_no_colours_but_those_of_the_palette():
    files = [path for path in Path(palette.__file__).parent.iterdir() if path.suffix in (".css", ".js", ".py")]
    own = {path.name for path in files if re.search(r"[\"' :](#[0-9a-fA-F]{6})\b", path.read_text("utf-8"))}
    assert own == {"palette.py", "page.js"}  # the script darkens walls towards black
    known = palette.style_sheet()
    for path in files:
        if path.suffix != ".py":
            for name in re.findall(r'var\(--([\w-]+)\)|colour\("([\w-]+)"\)', path.read_text("utf-8")):
                name = name[0] or name[1]
                assert f"--{name}:" in known or name in ("swatch", "ring", "tall"), (path.name, name)
