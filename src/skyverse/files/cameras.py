"""Cameras from files, YAML or JSON."""

from pathlib import Path

from pydantic import ValidationError

from skyverse.errors import InputError, require_file, shown
from skyverse.files.document import explained, parse, read_text
from skyverse.model.camera import Camera


def read_camera(path: Path) -> Camera:
    """Read a camera from a .yaml or .json file, or raise `InputError` that names file and field."""
    require_file(path)
    data = parse(path, read_text(path))
    if not isinstance(data, dict):
        raise InputError(f"{path}: expected a camera, a mapping with the key 'sensor' and others, found {shown(data)}")
    try:
        return Camera.model_validate({"name": path.stem} | data)
    except ValidationError as error:
        raise explained(path, error, data, set(Camera.model_fields)) from None
