"""The verb ``live``: a mission that another program steers."""

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from skyverse.cli.given_scenario import without_way
from skyverse.cli.option_types import FLAG, WHOLE, GivenMission
from skyverse.cli.report import json_text
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.live import Address

LOOPBACK = "127.0.0.1"
LEAST_TOKEN, MOST_TOKEN = 16, 1024
"""Characters of a token."""


@Parameter(name="*")
@dataclass(frozen=True)
class ReplannerOptions:
    """How far ahead motions are proven, and how much is tried.

    Parameters
    ----------
    horizon
        Seconds up to which motions are proven; when left out, half a second more than it takes to come to rest.
    lead
        Seconds from an observation at which a new motion begins: so long the answer may take.
    memory
        Seconds for which a mover that is not seen again stays in any case, at least the horizon, which is the default
        if it is longer than 3; later it is forgotten once it may be anywhere.
    candidates
        How many motions are tried for a UAV at most at each observation.
    """

    horizon: float | None = None
    lead: float = 0.1
    memory: float | None = None
    candidates: Annotated[int, WHOLE] = 128


_REPLANNER = ReplannerOptions()


def live(
    mission: GivenMission | None = None,
    /,
    *,
    listen: str | None = None,
    token: Path | None = None,
    setpoints: float | None = None,
    wgs84: Annotated[bool, FLAG] = False,
    replanner: ReplannerOptions = _REPLANNER,
    schema: Annotated[bool, FLAG] = False,
) -> None:
    """Steer a mission from another program: observations come in as JSON lines, the motions to fly go out.

    Observations are read from standard input, or from sockets, and answered one after another. A line that cannot be
    taken is answered by a sentence that says why, and changes nothing.

    Examples: `skyverse live out/map1.json < seen.jsonl`, `skyverse live out/map1.json --listen 5770 --setpoints 50`,
    `skyverse live --schema`

    Exit code: 0 at the end of the input, 2 for bad options or a bad mission, 130 after Ctrl-C.

    Parameters
    ----------
    mission
        A mission file.
    listen
        Listen here for any number of clients instead of reading standard input: HOST:PORT, or PORT on this machine
        alone, or the path of a Unix socket, which has a slash, for this user alone. Whoever can connect there steers.
    token
        A file that holds a word of 16 characters or more: clients must give it as their first line, {"token": "..."}.
        Needed where other machines can connect.
    setpoints
        How many setpoints a second answers hold, from now to the horizon: position, velocity and acceleration.
    wgs84
        Give setpoints in latitude, longitude and altitude too; the scenario must have an origin.
    schema
        Print the JSON Schema of the messages instead.
    """
    import skyverse as sky
    from skyverse.live import LiveSession, live_schema, load_kernels, serve_sockets, serve_streams

    if schema:
        if mission is not None:
            raise InputError(f"--schema: expected it alone, found {mission!r} with it")
        print(json_text(live_schema()), end="")
        return
    if mission is None:
        raise InputError("live: expected a mission; an example: skyverse live out/map1.json")
    where = None if listen is None else _address(listen)
    if token is not None and where is None:
        raise InputError("--token: expected --listen with it, found none")
    secret = None if token is None else _secret(token)
    if where is None and sys.stdin is None:
        raise InputError("live: expected messages on standard input, found it closed")
    given = sky.read_mission(mission)
    if not given.complete:
        print(without_way(given), file=sys.stderr)
    session = LiveSession(sky.Replanner(given, **vars(replanner)), setpoints=setpoints, wgs84=wgs84)
    load_kernels(given)
    try:
        if where is None:
            serve_streams(session, sys.stdin.buffer, sys.stdout.buffer)
        else:
            serve_sockets(session, where, token=secret, on_listening=_tell_where)
    except KeyboardInterrupt:
        print(session.summary(), file=sys.stderr)
        raise
    print(session.summary(), file=sys.stderr)


def _tell_where(found: str) -> None:
    print(f"Listening at {found}", file=sys.stderr)


def _address(text: str) -> "Address | Path":
    """Return where to listen, or raise `InputError`."""
    from skyverse.live import Address

    if "/" in text:
        return Path(text)
    host, colon, port = text.rpartition(":")
    if not re.fullmatch(r"\d{1,5}", port) or int(port) > 65535 or (colon and not host):
        raise InputError(f"--listen: expected HOST:PORT, PORT, or the path of a socket with a slash, found {text!r}")
    return Address(host.strip("[]") or LOOPBACK, int(port))


def _secret(path: Path) -> str:
    """Return the token that a file holds, or raise `InputError`."""
    try:
        word = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"--token: {path}: expected a text file, which cannot be read: {error}") from None
    if not LEAST_TOKEN <= len(word) <= MOST_TOKEN or not word.isascii() or any(map(str.isspace, word)):
        wanted = f"one word of {LEAST_TOKEN} to {MOST_TOKEN} letters, digits or signs"
        raise InputError(f"--token: {path}: expected {wanted}, found {len(word)} characters")
    return word
