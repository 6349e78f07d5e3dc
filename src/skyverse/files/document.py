"""YAML and JSON texts become data, and data become objects, or one sentence says what is wrong with them."""

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import TypeAdapter, ValidationError
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from skyverse.documents.json import read_json
from skyverse.documents.limits import read_bytes, text_of
from skyverse.documents.yaml import load_yaml
from skyverse.errors import InputError, first_line, printable, shown
from skyverse.files.grid_archive import beside
from skyverse.model.scenario import Scenario
from skyverse.model.wrong_values import wrong_field


def read_text(path: Path) -> str:
    """Return the text of a file, or raise `InputError`."""
    return text_of(read_bytes(path), path)


def parse(path: Path, text: str) -> Any:
    """Return the data of a YAML or JSON file, or raise `InputError` with the line; no key may stand twice."""
    if path.suffix.lower() == ".json":
        return read_json(text, path)
    try:
        return load_yaml(text)
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


T = TypeVar("T")


class JsonFormat(Generic[T]):
    """A format of JSON files, each of which holds one object of a type.

    Parameters
    ----------
    kind
        The type.
    name
        What the file says its format is, such as ``"skyverse/mission/2"``.
    unwritten
        The fields that are neither written nor read; those of an object in a field stand in a dictionary under its
        name.
    """

    def __init__(self, kind: type[T], name: str, unwritten: dict[str, Any]) -> None:
        self.kind, self.name, self._unwritten = kind, name, unwritten

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
        data = _without(data, self._unwritten)
        if data["format"] != self.name:
            raise InputError(f"{source}: format: expected {self.name!r}, found {shown(data['format'], 60)}")
        try:
            return self._adapter.validate_python(data, context=beside(Path(source)))
        except ValidationError as error:
            raise explained(source, error, data, set()) from None

    def text(self, thing: T, context: dict[str, Any] | None = None) -> str:
        """Return an object as the text of its file, written with the context of its archive if there is one."""
        written = self._adapter.dump_json(thing, indent=1, exclude=self._unwritten, context=context)
        return written.decode() + "\n"


def _without(data: Any, fields: Mapping[str, Any]) -> Any:
    if not isinstance(data, dict):
        return data
    return {
        key: _without(value, fields[key]) if isinstance(fields.get(key), dict) else value
        for key, value in data.items()
        if fields.get(key) is not True
    }


def explained(source: object, error: ValidationError, data: Any, known: set[str]) -> InputError:
    """Return what pydantic found wrong as one sentence that names file and field; see `wrong_field`."""
    place, said = wrong_field(error, data, known)
    return InputError(": ".join(part for part in (str(source), place, said) if part))
