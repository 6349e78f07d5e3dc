"""The types of options that several verbs have."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from skyverse.cli.settings import whole_number

Output = Annotated[Path | None, Parameter(name=["--output", "-o"])]
AsJson = Annotated[bool, Parameter(name="--json", negative="")]
Whole = Annotated[int | None, Parameter(converter=whole_number)]
