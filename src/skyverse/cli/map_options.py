"""Options for the maps of a scenario, made of the classes that hold them; and what is told of reading the maps."""

import dataclasses
import inspect
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar

from cyclopts import Group, Parameter

from skyverse.cli.option_names import for_command_line, option_of
from skyverse.cli.places import (
    altitude_above_sea,
    altitude_of,
    height_above_ground,
    numbers_of,
    origin_of,
    places_of,
    tracking_error_of,
)
from skyverse.cli.streams import plain
from skyverse.cli.watch import console
from skyverse.errors import InputError
from skyverse.maps.assembly.options import BuildOptions, MapDetail, MapFiles, MapRegion
from skyverse.maps.georeference.reading import Raster, Reading
from skyverse.model.built_with import FILES
from skyverse.model.caution import stands_out, warning_of
from skyverse.model.vehicle_profiles import FleetLimits

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import Note


def _risk(word: str) -> tuple[str, float]:
    file, equals, text = word.rpartition("=")
    if not (file and equals and text):
        raise InputError(f"--soft-zones: expected FILE=RISK, as in zones.geojson=0.5, found {word!r}")
    try:
        return file, float(text)
    except ValueError:
        raise InputError(f"--soft-zones: expected a number after {file}=, found {text!r}") from None


def _licence(word: str) -> tuple[str, str]:
    file, equals, text = word.partition("=")
    if not (file and equals and text):
        raise InputError(f"--licence: expected FILE=TEXT, found {word!r}")
    return file, text


def _fill(text: str) -> float | str:
    try:
        return "nearest" if text == "nearest" else float(text)
    except ValueError:
        raise InputError(f"--fill-nodata: expected metres above sea level, or nearest, found {text!r}") from None


def _energy(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


class _TextOption(NamedTuple):
    """An option whose value is written otherwise than the parameter that it stands for.

    Attributes
    ----------
    kind
        The type of what is written.
    form
        How it is written, or ``""`` where the type says enough.
    value
        Makes the parameter's value of what is written.
    settings
        What cyclopts must know besides.
    """

    kind: Any
    form: str = ""
    value: Callable[[Any], Any] = lambda written: written
    settings: Parameter = Parameter(allow_leading_hyphen=True)


_several = Parameter(consume_multiple=True)
_TEXTS = {name: _TextOption(list[Path], settings=_several) for name in FILES} | {
    "soft_zones": _TextOption(list[str], "`FILE=RISK`", lambda words: list(map(_risk, words)), _several),
    "licence": _TextOption(list[str], "`FILE=TEXT`", lambda words: dict(map(_licence, words)), _several),
    "uav": _TextOption(
        list[str],
        "`46.81,9.85,60 m agl`, or `alpha=46.81,9.85,60 m agl` with a name; repeat --uav for more",
        lambda texts: places_of("--uav", "uav", texts),
    ),
    "target": _TextOption(
        list[str],
        "`46.806,9.845,60 m agl`, or a file of points, `towers.kml` or `towers.csv,60 m agl`; repeat --target for more",
        lambda texts: places_of("--target", "target", texts),
    ),
    "area": _TextOption(
        str, "`9.84,46.79,9.87,46.81`", lambda text: numbers_of("--area", "west,south,east,north in degrees", text, 4)
    ),
    "origin": _TextOption(str, "`46.81,9.85,1560 m amsl`", origin_of),
    "ground": _TextOption(str, "`0 m amsl`", lambda text: altitude_above_sea("--ground", text)),
    "ceiling": _TextOption(str, "`120 m agl`", lambda text: altitude_of("--ceiling", text)),
    "max_height": _TextOption(str, "`120 m agl`", lambda text: height_above_ground("--max-height", text)),
    "tracking_error": _TextOption(str, "`1.5,2`", tracking_error_of),
    "band": _TextOption(str, "`40,80`", lambda text: numbers_of("--band", "low,high in metres above ground", text, 2)),
    "fill_nodata": _TextOption(str, "`1550` or `nearest`", _fill),
    "terrain_unit": _TextOption(Literal["m", "ft", "us-ft"], settings=Parameter()),
    "nodata": _TextOption(float),
    "radius_field": _TextOption(list[str], settings=_several),
    "battery": _TextOption(str, "`77`, `77 Wh` or `20 min`", _energy),
    "home": _TextOption(
        str, "`46.81,9.85`", lambda text: numbers_of("--home", "latitude,longitude in degrees", text, 2)
    ),
}
"""By the option's name; the values of all others are numbers and words, written as they are."""
Verb = TypeVar("Verb", bound=Callable[..., object])
_where = Group("What part of the world, and how", sort_key=3)
MAPS = {
    MapFiles: Group("What to read", sort_key=1),
    FleetLimits: Group("What the UAVs are", sort_key=2),
    MapRegion: _where,
    MapDetail: _where,
    Raster: Group("How terrain files are to be read, where they do not say", sort_key=4),
    Reading: Group("How files of buildings and zones are to be read, where they do not say", sort_key=5),
}


def _name(owner: type, field: str) -> str:
    """Return the name of the option for a parameter, as ``terrain_crs`` for ``Raster.crs``."""
    return option_of(f"{owner.__name__}.{field}").removeprefix("--").replace("-", "_")


def _documentation(options: type) -> dict[str, str]:
    """Return the documentation of each attribute of an options class, those of its bases first."""
    found: dict[str, str] = {}
    for base in reversed(options.__mro__[:-1]):
        _, _, entries = inspect.cleandoc(base.__doc__ or "").partition("Attributes\n----------\n")
        found |= dict(re.findall(r"^(\w+)\n((?: .*\n?)+)", entries, re.MULTILINE))
    return {name: inspect.cleandoc(text) for name, text in found.items()}


def options_of(owners: Mapping[type, Group], without: Collection[str] = ()) -> Iterator[inspect.Parameter]:
    """Yield an option for each parameter of classes, with the documentation that it has there; the first of a name."""
    yielded = {"path", *without}  # the path of a raster: these are the files of --terrain
    for owner, group in owners.items():
        documented = _documentation(owner)
        for field in dataclasses.fields(owner):
            name = _name(owner, field.name)
            if name in yielded:
                continue
            yielded.add(name)
            said = re.sub(r'``"?(.*?)"?``', r"`\1`", " ".join(documented.get(field.name, "").split()))
            text = _TEXTS.get(name, _TextOption(None, settings=Parameter()))
            yield inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=field.default if text.kind is None else None,
                annotation=Annotated[
                    field.type if text.kind is None else text.kind | None,
                    text.settings,
                    Parameter(group=group, help=f"{said} Written as {text.form}." if text.form else said),
                ],
            )


def taking(owners: Mapping[type, Group], without: Collection[str] = ()) -> Callable[[Verb], Verb]:
    """Return what lets a verb take the options of `options_of` as its ``**given``, those that a user gives."""

    def with_options(verb: Verb) -> Verb:
        own = [one for one in inspect.signature(verb).parameters.values() if one.kind is not one.VAR_KEYWORD]
        verb.__signature__ = inspect.Signature([*own, *options_of(owners, without)])  # type: ignore[attr-defined]
        return verb

    return with_options


def values_of(owner: type, given: dict[str, Any]) -> dict[str, Any]:
    """Return the values of those parameters of a class whose options are given."""
    names = {field.name: _name(owner, field.name) for field in dataclasses.fields(owner)}
    return {
        field: _TEXTS[name].value(given[name]) if name in _TEXTS else given[name]
        for field, name in names.items()
        if name in given
    }


def map_files(given: Mapping[str, Any]) -> list[Path]:
    """Return all files that options of maps name."""
    files = [path for name in FILES - {"soft_zones"} for path in given.get(name, ())]
    return [*files, *(Path(file) for file, _ in map(_risk, given.get("soft_zones", ())))]


def build_options(name: str, given: dict[str, Any], on_note: "Callable[[Note], object]") -> BuildOptions:
    """Return the options of a scenario from those of the command line."""
    files, raster = values_of(MapFiles, given), values_of(Raster, given)
    files["terrain"] = [Raster(path, **raster) for path in files.get("terrain", ())]
    return BuildOptions(
        name,
        **files,
        **values_of(FleetLimits, given),
        **values_of(MapRegion, given),
        **values_of(MapDetail, given),
        reading=Reading(**values_of(Reading, given)),
        on_note=on_note,
    )


@contextmanager
def watched(notes: "list[Note]", missions: Sequence[str] = ()) -> "Iterator[Callable[[Note], None]]":
    """Yield a function that keeps notes, and shows the last one when a person watches.

    Where that ends in a refusal, all notes are printed, as they may explain it, unless it is one of a mission's file.
    """
    from rich.text import Text

    try:
        with console().status("reading maps") if sys.stderr.isatty() else nullcontext() as shown:

            def keep(note: "Note") -> None:
                notes.append(note)
                if shown is not None:
                    shown.update(Text(plain(told(note))[: console().width - 3]))

            yield keep
    except InputError as error:
        for note in () if str(error).startswith(tuple(missions)) else notes:
            print(told(note), file=sys.stderr)
        raise


def must_be_heeded(note: "Note") -> bool:
    """Tell whether a pilot must heed a note."""
    return note.heed or stands_out(note.text)


def told(note: "Note") -> str:
    """Return a note as it is printed."""
    text, file = for_command_line(note.text), Path(note.file).name
    return warning_of(file, text) if file and stands_out(text) else f"{file}: {text}" if file else text
