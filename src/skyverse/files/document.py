"""YAML and JSON texts become data, and data become objects, or one sentence says what is wrong with them."""

import dataclasses
import json
import re
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter, ValidationError
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from skyverse.documents.json import load_json
from skyverse.documents.limits import LimitError, require_length
from skyverse.documents.yaml import load_yaml
from skyverse.errors import InputError, did_you_mean, first_line, printable, shown, unreadable
from skyverse.files.grid_archive import GridArchive, arrays_beside
from skyverse.model.scenario import Scenario
from skyverse.model.wrong_values import complaint


def read_text(path: Path) -> str:
    """Return the text of a file, or raise `InputError`."""
    try:
        with unreadable(path):
            require_length(path)
            return path.read_text(encoding="utf-8")
    except LimitError as error:
        raise InputError(f"{path}: {error}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected a text file in UTF-8, found something else at byte {error.start}") from None


def parse(path: Path, text: str) -> Any:
    """Return the data of a YAML or JSON file, or raise `InputError` with the line; no key may stand twice."""
    try:
        if path.suffix.lower() == ".json":
            return load_json(text)
        return load_yaml(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: line {error.lineno} is not JSON: {error.msg}") from None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f"line {mark.line + 1} " if mark is not None else ""
        problem = printable(str(error.problem or error.context).strip().splitlines()[0])
        raise InputError(f"{path}: {line}is not YAML: {problem}") from None
    except RecursionError:
        raise InputError(f"{path}: its lists and objects are nested too deeply to be read here") from None
    except (YAMLError, ValueError) as error:
        raise InputError(f"{path}: {first_line(error)}") from None
    except (LookupError, AttributeError, TypeError) as error:  # ruamel.yaml's, where a value is not what its tag says
        raise InputError(f"{path}: a value is not what its tag says: {first_line(error)}") from None


_UNKNOWN_KEY_ERRORS = ("extra_forbidden", "unexpected_keyword_argument")
"""How pydantic calls an unknown key in a model and in a dataclass."""
T = TypeVar("T")


class JsonFormat(Generic[T]):
    """A format of JSON files, each of which holds one object of a type.

    Parameters
    ----------
    kind
        The type.
    name
        What the file says its format is, such as ``"skyverse/mission/2"``.
    renew
        Returns the data of an older version of the format as those of the newest, and other data as they are; raises
        `ValueError` if an older version has a field of a newer one.
    unwritten
        The fields that no file holds; those of an object in a field stand in a dictionary under its name.
    """

    def __init__(
        self, kind: type[T], name: str, renew: Callable[[Any], Any], unwritten: Mapping[str, Any] | None = None
    ) -> None:
        self.kind, self.name, self._renew, self._unwritten = kind, name, renew, dict(unwritten or {})

    @cached_property
    def _adapter(self) -> TypeAdapter[T]:
        return TypeAdapter(self.kind)

    def is_of(self, data: Any) -> bool:
        """Tell whether the data of a file are said to be in this format, of any version."""
        said = data.get("format") if isinstance(data, dict) else None
        return isinstance(said, str) and said.startswith(self.name.rpartition("/")[0] + "/")

    def require_name(self, source: object, data: Any) -> None:
        """Raise `InputError` for data that have fields of this format, but do not say which format they are in."""
        fields = {one.name for one in dataclasses.fields(self.kind)} - Scenario.model_fields.keys()  # type: ignore[arg-type]
        if isinstance(data, dict) and "format" not in data and len(fields & data.keys()) > 1:
            raise InputError(f"{source}: format: is missing; expected {self.name!r}")

    def from_data(self, source: str | Path, data: Any) -> T:
        """Return the object that the data of a file describe, or raise `InputError` that names file and field.

        Parameters
        ----------
        source
            The file; its large arrays are in the archive beside it.
        data
            Its data.
        """
        try:
            data = self._renew(data)
        except ValueError as error:
            raise InputError(f"{source}: {error}") from None
        if data["format"] != self.name:
            raise InputError(f"{source}: format: expected {self.name!r}, found {shown(data['format'], 60)}")
        try:
            return self._adapter.validate_python(data, context={"grids": arrays_beside(Path(source))})
        except ValidationError as error:
            raise explained(source, error, data, set()) from None

    def text(self, thing: T, archive: GridArchive | None = None) -> str:
        """Return an object as the text of its file; large arrays of its scenario go to the archive if there is one."""
        written = self._adapter.dump_json(thing, indent=1, exclude=self._unwritten, context={"side": archive})
        return written.decode() + "\n"


def explained(source: object, error: ValidationError, data: Any, known: set[str]) -> InputError:
    """Return what pydantic found wrong as one sentence that names file and field; see `wrong_field`."""
    place, said = wrong_field(error, data, known)
    return InputError(": ".join(part for part in (str(source), place, said) if part))


def wrong_field(error: ValidationError, data: Any, known: set[str]) -> tuple[str, str]:
    """Return the field that pydantic found wrong, empty if it is all of the data, and in a sentence what is wrong.

    Parameters
    ----------
    error
        What pydantic found.
    data
        The data that were read.
    known
        Keys that an unknown key may be a misspelling of.
    """
    # where a key is misspelt, the right one is missing, too: the misspelt one is the cause
    first = min(error.errors(include_url=False), key=lambda found: found["type"] not in _UNKNOWN_KEY_ERRORS)
    place, kind = _place(first["loc"], data, missing=first["type"] == "missing")
    found, near = first["input"], ""
    if first["type"] == "union_tag_invalid":
        place += f".{_name_of_type(first['loc'])}"
        found = first["ctx"]["tag"]
        near = did_you_mean(found, re.findall(r"'([^']+)'", first["ctx"]["expected_tags"]))
    if first["type"] in _UNKNOWN_KEY_ERRORS:
        key = str(first["loc"][-1])
        if kind is not None and key in known:
            name = _name_of_type(first["loc"][:-2])
            said = f"the {name} {kind!r} has no such key; the key {name!r} says which {name} it is"
            return place, said
        return place, f"there is no such key{did_you_mean(key, known)}"
    if first["type"] == "missing":
        return place, "is missing"
    said = re.sub(r"\S{80,}", lambda word: f"{word[0][:60]}...", complaint(first))
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    but = "" if first["type"] == "value_error" and isinstance(found, dict) else f", found {shown(found, 60)}"
    return place, f"{said}{but}{near}{more}"


def _name_of_type(loc: tuple[int | str, ...]) -> str:
    """Return the key that says of which type the data at a place are."""
    return "motion" if loc[-1] == "motion" else "shape"


def _place(loc: tuple[int | str, ...], data: Any, missing: bool) -> tuple[str, str | None]:
    """Return where in a file's data a place of pydantic's is, and the type that pydantic names just before its end.

    On the way, pydantic names types, validators, and the first entry of a list where the file has that entry alone.
    These do not stand in the file, and are left out; a key that is missing stands at the end.
    """
    place, kind = "", None
    for k, part in enumerate(loc):
        last = k == len(loc) - 1
        if isinstance(part, int):
            if not isinstance(data, dict | str | float | int):
                place += f"[{part}]"
                data = data[part] if isinstance(data, list | tuple) and part < len(data) else None
        elif _stands_in(data, part) or (missing and last):
            place += f".{printable(part, 60)}" if place else printable(part, 60)
            data = data.get(part) if isinstance(data, dict) else None
        elif k == len(loc) - 2:
            kind = part
    return place, kind


def _stands_in(data: Any, part: str) -> bool:
    """Tell whether a key stands in data; of other data than mappings, whether it is a key at all."""
    return part in data if isinstance(data, dict) else not part.startswith(("function-", "tuple[", "literal["))


def keys_of_schema(schema: Any) -> set[str]:
    """Return all keys that a JSON Schema knows."""
    keys: set[str] = set()
    if isinstance(schema, dict):
        keys.update(schema.get("properties", {}))
        for value in schema.values():
            keys |= keys_of_schema(value)
    return keys
