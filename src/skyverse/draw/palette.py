"""The colours of all pictures, on pages and in figures: one home, so that one thing has one colour everywhere."""

from skyverse.model.shapes import FENCE, NO_FLY_ZONE

TRACKS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""The colours of UAVs: Okabe and Ito's, which all kinds of colour vision tell apart, without black and yellow."""
FINDINGS = {"warning": "#d97706", "error": "#dc2626"}
"""The colours of what is wrong, by its severity; the error's is also that of limits."""
TARGET_TO_REACH, TARGET_TO_SPARE = "#b5179e", "#8a94a3"
"""The colours of a target before anything is planned, and of one to which no UAV flies."""
KINDS = {
    "building": "#9aa3b4",
    "tree": "#6f8f57",
    "vegetation": "#6f8f57",
    "power line": "#6b5b95",
    NO_FLY_ZONE: "#c8323c",
    FENCE: "#1f6f8b",
    "restricted": "#c8323c",
    "prohibited": "#a3123a",
    "school": "#b8860b",
    "hospital": "#c2548b",
    "water": "#4f86c6",
    "bridge": "#a0785a",
    "construction": "#b5a27c",
    "furniture": "#5c6f82",
}
"""The colours of obstacles and zones, by a word in the name of their kind."""
OTHER_KINDS = ("#7b61a8", "#3b8ea5", "#a0522d", "#5f7f3f", "#96487a", "#5a6ea8", "#8a7a2a", "#4d7f74")
"""The colours of other kinds, in turn."""
GROUND = ("#46573f", "#71835a", "#a8a877", "#cdb98e", "#e3d6bf", "#f6f3ee")
"""The colours of the ground in space, from low and shaded to high and lit."""
GROUND_ON_MAP = ("#a8bb93", "#cdcea4", "#d6c29e", "#c5b2a0", "#d6d1ce", "#e8e9ec")
"""The colours of the ground on the map, from the lowest to the highest: meadow, straw, earth, rock, scree and snow.

They are pale, so that paths stand out.
"""
SURVEY = "#4c1d95"
"""The colour of what a survey is to see, and of its photos."""
COUNTS = ("#fff3b0", "#b8dd9a", "#57b79a", "#2c8ab0", "#2b5797", "#2a2664")
"""The colours of places from one photo to the most; none is the colour of an error."""
DISTANCES = ("#16425f", "#2f7fb3", "#8fcbe0", "#fbf1bd")
"""The colours of ground sample distances from the finest to the coarsest that is asked for."""
LIGHT = {
    "ground": "#f4f6f8",
    "card": "#ffffff",
    "ink": "#17202b",
    "soft": "#5b6776",
    "line": "#dde3ea",
    "grid": "#e6ebf0",
    "accent": "#0b62a8",
    "press": "#e3eef8",
    "good": "#0a6b4b",
    "good-ground": "#e4f4ed",
    "warn": "#8a5300",
    "warn-ground": "#fdf1dc",
    "bad": "#a81e1e",
    "bad-ground": "#fdeaea",
    "floor": "#eef1f5",
    "ringline": "#5b677699",
    "ceiling": "#b4530a",
    "box": "#8795a8",
    "edge": "#66758a",
    "mover": "#9d174d",
    "active": "#b91c1c",
    "zone": "#d9822b",
    "earth": "#d3c7b2",
    "earthline": "#94836a",
}
"""The colours of a page, and of figures, by what they are for; those of a dark page have the same names."""
DARK = {
    "ground": "#0f141a",
    "card": "#171e26",
    "ink": "#e6ebf1",
    "soft": "#98a5b4",
    "line": "#2a343f",
    "grid": "#27303a",
    "accent": "#6cb6f5",
    "press": "#203243",
    "good": "#67d3a8",
    "good-ground": "#10302a",
    "warn": "#f2bd66",
    "warn-ground": "#362b14",
    "bad": "#ff9a94",
    "bad-ground": "#3d1d1f",
    "floor": "#1d2630",
    "ringline": "#98a5b499",
    "ceiling": "#f0a04b",
    "box": "#7587a0",
    "edge": "#8c9db3",
    "mover": "#f472b6",
    "active": "#f87171",
    "zone": "#f0a04b",
    "earth": "#4a4335",
    "earthline": "#a4937a",
}
ON_MAP = {"map-ink": LIGHT["ink"], "map-rim": "#ffffff", "contour": "#463c2d", "terrain": "#c5b28f"}
"""Colours on the map and of the terrain, whose ground is light on a dark page too."""


def style_sheet() -> str:
    """Return the colours of a page as variables of its style sheet."""
    light, dark = (" ".join(f"--{name}: {tone};" for name, tone in one.items()) for one in (LIGHT | ON_MAP, DARK))
    return (
        f":root {{ color-scheme: light dark; {light} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    )
