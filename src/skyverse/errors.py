"""The one error that bad input ends in, and sentences that carry the names of parameters as data.

A user of the library reads names of parameters, a user of the command line the options that stand for them.
"""

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import islice
from numbers import Integral, Real
from pathlib import Path
from typing import Self, TypeGuard


@dataclass(frozen=True)
class Remedy:
    """A parameter to give so that something is read as it is meant.

    Attributes
    ----------
    field
        Its name, such as ``"geoid"``, or ``"Raster.crs"`` for the parameter of a class.
    value
        What to give; ``None`` where only the user can know.
    purpose
        What that is good for, such as ``"to take them as feet"``.
    """

    field: str
    value: str | float | None = None
    purpose: str = ""


Spelling = Callable[[str, str | float | None], str]
"""Writes a parameter and the value to give it, if one is known."""


def _in_python(field: str, value: str | float | None) -> str:
    """Write a parameter and its value as a caller of the library does."""
    if value is None:
        return field
    owner, dot, name = field.rpartition(".")
    given = f"{name}={value!r}" if isinstance(value, str | bool) else f"{name}={value:.12g}"
    return f"{owner}({given})" if dot else given


class Sentence(str):
    """A sentence for a person, which knows the parameters that it names; as a text it names them as Python does.

    Parameters
    ----------
    text
        What is to be said, without the parameters.
    field
        The parameter that it is about, whose name stands before the text.
    give
        Parameters any one of which helps; they stand behind the text.
    """

    text: str
    field: str | None
    give: tuple[Remedy, ...]

    def __new__(cls, text: str, *, field: str | None = None, give: Sequence[Remedy] = ()) -> Self:
        """Compose the sentence."""
        self = super().__new__(cls, _composed(text, field, give, str, _in_python))
        self.text, self.field, self.give = text, field, tuple(give)
        return self

    def spelt(self, name: Callable[[str], str], spelling: Spelling) -> str:
        """Return the sentence with parameters written otherwise: by `name`, and with their values by `spelling`."""
        return _composed(self.text, self.field, self.give, name, spelling)

    def removeprefix(self, prefix: str, /) -> "Sentence":
        """Return the sentence without the beginning of its text."""
        return Sentence(self.text.removeprefix(prefix), field=self.field, give=self.give)


def in_words(said: str) -> str:
    """Return a sentence with its parameters in plain words, for those who read neither code nor options."""

    def words(field: str) -> str:
        return field.replace(".", " ").replace("_", " ").lower()

    def given(field: str, value: str | float | None) -> str:
        return words(field) if value is None or value is True else f"{words(field)} {value!r}"

    return said.spelt(words, given) if isinstance(said, Sentence) else said


def _composed(
    text: str, field: str | None, give: Sequence[Remedy], name: Callable[[str], str], spelling: Spelling
) -> str:
    before = "" if field is None else f"{name(field)}: "
    remedies = " or ".join(f"{spelling(one.field, one.value)} {one.purpose}".rstrip() for one in give)
    return f"{before}{text.removesuffix('.')}; give {remedies}" if give else f"{before}{text}"


class InputError(ValueError):
    """What the user gave cannot be used; the message names file and field, what was expected and found.

    Parameters
    ----------
    message
        What is wrong, in one sentence.
    field
        The parameter whose value cannot be used, as a caller of the library names it.
    give
        Parameters of which any one helps.
    """

    def __init__(self, message: str, *, field: str | None = None, give: Sequence[Remedy] = ()) -> None:
        whole = message if isinstance(message, Sentence) else Sentence(message, field=field, give=give)
        super().__init__(whole)
        self.sentence = whole


def printable(text: str, most: int = 200) -> str:
    """Return at most so many characters of a text on one line, without what cannot be printed."""
    seen = "".join(c if c.isprintable() else " " for c in text[: 2 * most].encode("utf-8", "replace").decode())
    return " ".join(seen.split())[:most]


def require_kind(value: object, kinds: type | tuple[type, ...], field: str) -> None:
    """Raise `InputError` for a value of another kind."""
    if not isinstance(value, kinds):
        names = [kind.__name__ for kind in (kinds if isinstance(kinds, tuple) else (kinds,))]
        expected = " or ".join(f"{'an' if name[0].lower() in 'aeio' else 'a'} {name}" for name in names)
        raise InputError(f"expected {expected}, found {shown(value)}", field=field)


def require_flag(value: object, field: str) -> None:
    """Raise `InputError` for what is neither true nor false."""
    if not isinstance(value, bool):
        raise InputError(f"expected True or False, found {shown(value)}", field=field)


def require_choice(value: object, choices: Iterable[str], field: str) -> None:
    """Raise `InputError` for what is none of some words."""
    words = tuple(choices)
    if not (isinstance(value, str) and value in words):
        raise InputError(f"expected one of {', '.join(words)}, found {shown(value)}", field=field)


def path_of(value: object, field: str = "path") -> Path:
    """Return the path that a text or a path is, or raise `InputError`."""
    require_kind(value, (str, Path), field)
    return Path(value)  # type: ignore[arg-type]


def is_number(value: object) -> TypeGuard[float]:
    """Tell whether a value is a number that a float can hold; true and false are none."""
    most = sys.float_info.max
    return isinstance(value, Real) and not isinstance(value, bool) and abs(value) <= most  # type: ignore[operator]


def require_number(
    value: object, field: str, what: str = "a number", least: float = -math.inf, most: float = math.inf
) -> None:
    """Raise `InputError` for what is no finite number, or less than the least or more than the most."""
    _require(is_number(value) and least <= value <= most, value, field, what, (least, most))


def require_row(value: object, count: int, field: str, least: float = -math.inf) -> None:
    """Raise `InputError` for what is no row of so many finite numbers, or has one that is less than the least."""
    sound = isinstance(value, list | tuple) and len(value) == count
    sound = sound and all(is_number(one) and one >= least for one in value)  # type: ignore[attr-defined]
    _require(sound, value, field, f"{count} numbers", (least, math.inf))


def require_whole(value: object, field: str, least: int, most: float = math.inf, *, even: bool = False) -> None:
    """Raise `InputError` for what is no whole number from the least to the most, or not even where it must be."""
    sound = isinstance(value, Integral) and is_number(value) and least <= value <= most and not (even and value % 2)
    _require(sound, value, field, f"{'an even' if even else 'a whole'} number", (least, most))


def _require(sound: bool, value: object, field: str, what: str, limits: tuple[float, float]) -> None:
    if not sound:
        least, most = limits
        span = "" if least == -math.inf else f" from {least:g} {'on' if most == math.inf else f'to {most:g}'}"
        raise InputError(f"expected {what}{span}, found {shown(value)}", field=field)


def parse_number(text: str | float | None, where: str, least: float = -math.inf, most: float = math.inf) -> float:
    """Return a finite number, or raise `InputError`; `where` begins the message."""
    try:
        value = math.nan if text is None else float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and least <= value <= most):
        span = "" if math.isinf(least) else f" from {least:g}" + ("" if math.isinf(most) else f" to {most:g}")
        raise InputError(f"{where}: expected a number{span}, found {shown(text)}")
    return value


def shown(value: object, most: int = 40) -> str:
    """Return at most so many printable characters of a value as Python writes it, for messages; cut, it ends in "…"."""
    text = ""
    for piece in _pieces(value):
        text += piece
        if len(text) > 2 * most:
            break
    said = printable(text, most + 1)
    return said if len(said) <= most else f"{said[: most - 1]}…"


def _pieces(value: object) -> Iterator[str]:
    """Yield how Python writes a value, piece by piece, so that nobody need write all of a large one."""
    if isinstance(value, dict):
        yield "{"
        for number, (key, held) in enumerate(value.items()):
            yield ", " if number else ""
            yield from _pieces(key)
            yield ": "
            yield from _pieces(held)
        yield "}"
    elif type(value) in (list, tuple):
        yield "[" if isinstance(value, list) else "("
        for number, held in enumerate(value):  # type: ignore[arg-type]
            yield ", " if number else ""
            yield from _pieces(held)
        yield "]" if isinstance(value, list) else ",)" if len(value) == 1 else ")"  # type: ignore[arg-type]
    elif isinstance(value, str | bytes):
        yield repr(value[:1000])
    elif isinstance(value, int) and value.bit_length() > 10_000:
        yield f"a whole number of about {round(value.bit_length() * 0.30103):,} digits"
    else:
        yield repr(value)


def first_line(error: BaseException) -> str:
    """Return the first line, 200 characters at most, of what another library's error says, or else its name."""
    return printable((str(error).strip().splitlines() or [""])[0]) or type(error).__name__


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the end of a sentence that suggests the known words nearest to a word; empty where none is near."""
    spelt = {one.lower(): one for one in known if one != word}
    near = [repr(spelt[one]) for one in get_close_matches(word.lower(), spelt, n=3, cutoff=0.7)]
    return f"; did you mean {' or '.join(near)}?" if near else ""


MAX_SEARCHED_FILES = 5000
"""Files of a folder at most among which those of similar names are sought."""


def require_file(path: Path, names: Sequence[str] = ()) -> None:
    """Raise `InputError` for a path that is no file to read from: nothing, a folder, or a device.

    Where there is nothing of that name, the message suggests the files of its folder whose names are nearest.

    Parameters
    ----------
    path
        The path.
    names
        The built-in scenarios that could be meant instead.
    """
    if path.is_file():
        return
    if path.is_dir():
        raise InputError(f"{path}: expected a file, found a folder")
    if path.exists() or path.is_symlink():
        found = "a device or a pipe" if path.exists() else "a link that leads nowhere"
        raise InputError(f"{path}: expected a file, found {found}")
    known = list(names)
    with suppress(OSError):
        known += sorted(entry.name for entry in islice(path.parent.iterdir(), MAX_SEARCHED_FILES))
    near = did_you_mean(path.name, known)
    said = ", nor a built-in scenario" if names else ""
    if names and not near:
        near = f"; built in are {', '.join(names)}"
    raise InputError(f"{printable(str(path), 300)}: no such file{said}{near}")


@contextmanager
def unreadable(path: object, said: str = "", *kinds: type[BaseException]) -> Iterator[None]:
    """Turn what goes wrong while a file is read into `InputError`, which names the file.

    Parameters
    ----------
    path
        The file.
    said
        What is wrong where another library raises one of `kinds`; the first line of its message follows.
    kinds
        The errors of that library. Errors of the operating system are always turned.
    """
    try:
        yield
    except (InputError, GeneratorExit, KeyboardInterrupt, SystemExit):
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except kinds as error:
        raise InputError(f"{path}: {said}: {first_line(error)[:200]}") from None
