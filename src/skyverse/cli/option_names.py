"""The one place that knows which option stands for which parameter of the library, and what is said of wrong words."""

import inspect
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import reduce

from cyclopts import App, CoercionError, CycloptsError, MissingArgumentError, UnknownCommandError, UnusedCliTokensError

from skyverse.errors import InputError, Sentence

_running: ContextVar[tuple[App, tuple[str, ...]] | None] = ContextVar("running", default=None)
"""The command line's application, and the verb that it runs."""

OPTIONS = {
    "Lattice.step": "--lattice-step",
    "Origin.geoid": "--geoid",
    "Raster.band": "--terrain-band",
    "Raster.crs": "--terrain-crs",
    "Raster.unit": "--terrain-unit",
    "Sensor.delay": "--sensor-delay",
    "Sensor.rate": "--sensor-rate",
    "fences": "--fence",
    "licences": "--licence",
    "mission": "MISSION",
    "missions": "MISSIONS",
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
    "home": "latitude,longitude",
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


@contextmanager
def running(app: App, words: Sequence[str]) -> Iterator[None]:
    """Let sentences name options of the verb that some words run as they are, and others behind their own verb."""
    before = _running.set((app, app.parse_commands(words)[0]))
    try:
        yield
    finally:
        _running.reset(before)


@contextmanager
def as_in(verb: str) -> Iterator[None]:
    """Let sentences name options as if another verb were run, whose options fit what they are about."""
    run = _running.get()
    before = _running.set(run if run is None else (run[0], (verb,)))
    try:
        yield
    finally:
        _running.reset(before)


def option_of(field: str) -> str:
    """Return the option that stands for a parameter, as ``--terrain-crs`` for ``Raster.crs``."""
    name = field.rpartition(".")[2]
    return OPTIONS.get(field) or OPTIONS.get(name) or f"--{name.replace('_', '-')}"


def for_command_line(said: str | InputError) -> str:
    """Return a sentence of the library, or the message of its error, with options in place of parameters."""
    sentence = said.sentence if isinstance(said, InputError) else said
    return sentence.spelt(option_of, _given) if isinstance(sentence, Sentence) else sentence


def _given(field: str, value: str | float | None) -> str:
    """Return an option and its value, as a user types them, behind its verb if another one is run."""
    option = told_option(field)
    if value is True:
        return option
    shown = PLACEHOLDERS.get(field, "") if value is None else value if isinstance(value, str) else f"{value:.12g}"
    return f"{option} {shown}".rstrip()


def told_option(field: str) -> str:
    """Return the option that stands for a parameter, behind its verb if another one is run."""
    option, run = option_of(field), _running.get()
    if run is None:
        return option
    for verb in (run[1], ("plan",), ("scenario", "build")):
        app = reduce(App.__getitem__, verb, run[0])
        if any(option in one.names for one in app.assemble_argument_collection()):
            return " ".join([*(() if verb == run[1] else verb), option])
    return option


def refusal(error: CycloptsError) -> str:
    """Return in one sentence what is wrong with a command line, as cyclopts found it."""
    if isinstance(error, UnusedCliTokensError):
        return _too_many_words(error)
    if isinstance(error, MissingArgumentError) and error.argument is not None and not error.argument.tokens:
        return _missing_word(error)
    if isinstance(error, UnknownCommandError) and error.app is not None and error.unused_tokens:
        word, verbs = error.unused_tokens[0], [name for name in error.app if not name.startswith("-")]
        under = [f"{verb} {word}" for verb in verbs if word in list(error.app[verb]) and not word.startswith("-")]
        if under:
            return f"expected a verb, found {word!r}; did you mean {under[0]!r}?"
    said = " ".join(str(error).split())
    token = error.token if isinstance(error, CoercionError) else None
    if token is not None and token.keyword == "--planner" and ":" in token.value:
        return f"{said} A planner of one's own, module:Class, stands in a study file, as skyverse compare takes it."
    return said


def _too_many_words(error: UnusedCliTokensError) -> str:
    """Say how many words a verb takes, and how several values of an option are given."""
    found = " ".join(map(repr, error.unused_tokens or ()))
    given = inspect.signature(error.target).parameters.values() if error.target is not None else ()
    taken = [one.name.upper() for one in given if one.kind is one.POSITIONAL_ONLY]
    verb = " ".join(error.command_chain or ())
    return (
        f"{verb}: expected {' and '.join(taken) or 'options'} alone, found {found} too; "
        "several values of an option stand each after its name, as in --uav A --uav B"
    )


def _missing_word(error: MissingArgumentError) -> str:
    """Say which word a verb, or a value which option, lacks, with the first example of the verb's help."""
    verb = " ".join(error.command_chain or ())
    example = re.search(r"`(skyverse [^`]+)`", inspect.getdoc(error.target) or "")
    more = f"; an example: {' '.join(example[1].split())}" if example else ""
    if error.keyword is not None:
        return f"{error.keyword}: expected a value after it, found none"
    return f"{verb}: expected {error.argument.name if error.argument is not None else 'more'}{more}"
