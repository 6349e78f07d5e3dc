"""UAVs and targets by their index or name."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from skyverse.errors import InputError, did_you_mean, shown


class Named(Protocol):
    """What has a name."""

    @property
    def name(self) -> str:
        """Its name."""


def index_of(things: Sequence[Named], which: int | str, field: str) -> int:
    """Return the index of a thing, which is given by its index or its name.

    Raises
    ------
    InputError
        If there is none, named by `field`.
    """
    names = [thing.name for thing in things]
    if isinstance(which, str) and which in names:
        return names.index(which)
    if isinstance(which, int | np.integer) and not isinstance(which, bool) and 0 <= which < len(things):
        return int(which)
    near = did_you_mean(which, names) if isinstance(which, str) else ""
    known = f"an index below {len(things)}, or a name," if things else "none, since there are none,"
    raise InputError(f"expected {known} found {shown(which)}{near}", field=field)
