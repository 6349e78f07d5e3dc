"""The one place that knows which option of the command line stands for which parameter of the library."""

from skyverse.errors import InputError, Sentence

OPTIONS = {
    "Lattice.step": "--lattice-step",
    "Origin.geoid": "--geoid",
    "Raster.band": "--terrain-band",
    "Raster.crs": "--terrain-crs",
    "Raster.unit": "--terrain-unit",
    "Sensor.delay": "--sensor-delay",
    "Sensor.rate": "--sensor-rate",
    "licences": "--licence",
    "mission": "MISSION",
    "uavs": "--uav",
    "targets": "--target",
}
"""The options whose names are not those of their parameters, written with dashes."""
PLACEHOLDERS = {
    "Lattice.step": "METRES",
    "Origin.geoid": "METRES",
    "Raster.unit": "UNIT",
    "Reading.buffer": "METRES",
    "Reading.building_height": "METRES",
    "area": "west,south,east,north",
    "ceiling": "ALTITUDE",
    "fill_nodata": "METRES",
    "geoid": "METRES",
    "ground": "'0 m amsl'",
    "ground_clearance": "METRES",
    "margin": "METRES",
    "max_height": "HEIGHT",
    "origin": "latitude,longitude,altitude",
    "soft_zones": "FILE=RISK",
    "terrain": "FILE",
    "tracking_error": "horizontal,vertical",
    "uavs": "latitude,longitude,altitude",
    "voxels": "FILE",
}
"""What is written after an option whose value only the user knows."""


def option_of(field: str) -> str:
    """Return the option that stands for a parameter, as ``--terrain-crs`` for ``Raster.crs``."""
    name = field.rpartition(".")[2]
    return OPTIONS.get(field) or OPTIONS.get(name) or f"--{name.replace('_', '-')}"


def for_command_line(said: str | InputError) -> str:
    """Return a sentence of the library, or the message of its error, with options in place of parameters."""
    sentence = said.sentence if isinstance(said, InputError) else said
    return sentence.spelt(option_of, _given) if isinstance(sentence, Sentence) else sentence


def _given(field: str, value: str | float | None) -> str:
    """Return an option and its value, as a user types them."""
    if value is True:
        return option_of(field)
    shown = PLACEHOLDERS.get(field, "") if value is None else value if isinstance(value, str) else f"{value:.12g}"
    return f"{option_of(field)} {shown}".rstrip()
