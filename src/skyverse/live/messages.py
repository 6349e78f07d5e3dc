"""The messages of a steered mission, one a line as JSON: observations come in; motions, or refusals, go out.

Lines of JSON become observations; how long a line may be is counted before it is read.
"""

from functools import cache
from typing import Annotated, Any, Final, Literal

from pydantic import Field, ValidationError
from pydantic.json_schema import models_json_schema

from skyverse.documents.json import read_json
from skyverse.errors import InputError
from skyverse.live.tracks import Sighting
from skyverse.model.frame import Origin
from skyverse.model.quantities import Model, NonNegative, Point
from skyverse.model.shapes import Obstacle, Zone
from skyverse.model.wrong_values import keys_of_schema, wrong_field

LIVE_1: Final = "skyverse/live/1"
"""The version of these messages."""
Points = tuple[tuple[float, float, float], ...]
"""Rows of three numbers."""


class UAVState(Model):
    """Where a UAV was found to be, and how fast.

    Attributes
    ----------
    position
        x, y, z, local metres.
    velocity
        x, y, z, m/s.
    """

    position: Point
    velocity: Point


class ObservationMessage(Model):
    """What was seen at an instant; `Replanner.observe` says what becomes of it.

    Attributes
    ----------
    t
        Seconds into the mission.
    movers
        Movers that were seen.
    obstacles, zones
        Obstacles that stand still, and zones, that were not known before, as in scenarios.
    states
        Where UAVs were found to be, by their names or their indices.
    targets
        Other targets, local metres, of UAVs by their names or their indices.
    gone
        Names of movers whose places were seen empty.
    deadline_ms
        Milliseconds after which no further motions are tried.
    """

    t: NonNegative
    movers: tuple[Sighting, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    states: Annotated[dict[str, UAVState], Field(default_factory=dict)]
    targets: Annotated[dict[str, Point], Field(default_factory=dict)]
    gone: tuple[str, ...] = ()
    deadline_ms: NonNegative | None = None


class TokenMessage(Model):
    """The first line of a client where a token is asked for: what the file of the token holds."""

    token: str


class AnnouncedUAV(Model):
    """A UAV of the mission: its index, its name, where it starts, and its target, local metres, if it has one."""

    uav: int
    name: str
    start: Point
    target: Point | None


class Hello(Model):
    """The first message that goes out.

    Attributes
    ----------
    format
        Says what the messages are.
    version
        Of skyverse.
    mission
        The name of the scenario.
    uavs
        In the order of all answers.
    horizon, lead, memory
        Seconds; see `Replanner`.
    origin
        Where the zero of local metres lies, if that is known.
    cautions
        What the mission leaves out or assumes, and a pilot must heed.
    """

    format: Literal["skyverse/live/1"] = LIVE_1
    version: str
    mission: str
    uavs: tuple[AnnouncedUAV, ...]
    horizon: float
    lead: float
    memory: float
    origin: Origin | None
    cautions: tuple[str, ...] = ()


class YawMessage(Model):
    """Where a UAV's nose points, counterclockwise from east; before the first instant and after the last it stays.

    Attributes
    ----------
    t
        n seconds into the mission, rising; one at least.
    yaw, yaw_rate
        n rad, without leaps of whole turns, and n rad/s; between two instants the yaw rate is linear.
    """

    t: tuple[float, ...]
    yaw: tuple[float, ...]
    yaw_rate: tuple[float, ...]


class MotionMessage(Model):
    """What a UAV flies from now on; after the last knot it stays where it is.

    Attributes
    ----------
    knots
        n + 1 seconds into the mission, rising; the first one is now or shortly before.
    coefficients
        n pieces of rows of x, y, z, metres: in piece k the UAV is at the sum over j of ``coefficients[k][j]`` times
        ``(t - knots[k])`` to the power j.
    yaw
        Where its nose points meanwhile.
    """

    knots: tuple[float, ...]
    coefficients: tuple[Points, ...]
    yaw: YawMessage


class Setpoints(Model):
    """The same motion at instants from now to the horizon.

    Attributes
    ----------
    t
        n seconds into the mission.
    position, velocity, acceleration
        n rows of x, y, z: local metres, m/s, m/s^2.
    yaw, yaw_rate
        n rad, counterclockwise from east, and n rad/s.
    wgs84
        n rows of latitude and longitude, degrees, and altitude above mean sea level, metres, where these were asked
        for.
    """

    t: tuple[float, ...]
    position: Points
    velocity: Points
    acceleration: Points
    yaw: tuple[float, ...]
    yaw_rate: tuple[float, ...]
    wgs84: Points | None = None


class UAVAnswer(Model):
    """What is answered for one UAV.

    Attributes
    ----------
    uav, name
        Its index and its name.
    kept
        Whether it goes on with the motion that it was flying.
    proven
        Whether its motion keeps clear of everything that is known up to the horizon, and ends at rest.
    clear_until
        The instant up to which it is clear, seconds into the mission.
    sentence
        What is proven; or which mover it may come too near to, when and where.
    arrival
        The instant at which its motion ends at its target, seconds into the mission; none if it ends elsewhere.
    milliseconds
        How long it took to find the motion.
    motion
        What it flies from now on.
    setpoints
        The same, sampled, where that was asked for.
    """

    uav: int
    name: str
    kept: bool
    proven: bool
    clear_until: float
    sentence: str
    arrival: float | None
    milliseconds: float
    motion: MotionMessage
    setpoints: Setpoints | None = None


class Answer(Model):
    """What is answered to an observation.

    Attributes
    ----------
    line
        The number of the line that the observation stood in, from 1 on; none if another client sent it.
    t
        Now, seconds into the mission: the latest instant of which anything was observed.
    uavs
        What is answered for each UAV, in their order.
    forgotten
        Names of movers that were kept in mind up to now, but were not seen for so long that they may be anywhere: what
        is proven does not count with them any more.
    """

    line: int | None
    t: float
    uavs: tuple[UAVAnswer, ...]
    forgotten: tuple[str, ...] = ()


class LineFault(Model):
    """Why a line was not taken: its number from 1 on, the field that is wrong if it is one, and a sentence."""

    line: int
    field: str | None
    message: str


class Refusal(Model):
    """What is answered to a line that cannot be taken; nothing has changed."""

    error: LineFault


def live_schema() -> dict[str, Any]:
    """Return the JSON Schema of the messages: ``$defs`` has one entry a message; the whole allows any that goes out."""
    kinds: list[Any] = [ObservationMessage, TokenMessage, Hello, Answer, Refusal]
    _, schema = models_json_schema([(kind, "validation") for kind in kinds], title=LIVE_1)
    out = [{"$ref": f"#/$defs/{kind.__name__}"} for kind in kinds[2:]]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "oneOf": out}


MAX_LINE = 2**23
"""Bytes of a line at most, 8 MB: an observation of ten thousand obstacles."""


class LineSplitter:
    """Splits what arrives in chunks into lines, and holds no more of an overlong line than is needed to refuse it.

    Attributes
    ----------
    most
        Bytes of a line that are held at most.
    """

    def __init__(self, most: int = MAX_LINE + 1) -> None:
        self.most = most
        self._held = bytearray()

    def lines(self, chunk: bytes) -> list[bytes]:
        """Return the lines that a chunk completes, without their ends."""
        *whole, rest = chunk.split(b"\n")
        done = []
        for part in whole:
            self._hold(part)
            done.append(bytes(self._held))
            self._held.clear()
        self._hold(rest)
        return done

    def end(self) -> list[bytes]:
        """Return what is left at the end of the input as its last line, if there is anything."""
        rest = bytes(self._held)
        self._held.clear()
        return [rest] if rest else []

    def _hold(self, part: bytes) -> None:
        self._held += part[: max(self.most - len(self._held), 0)]


def json_of_line(line: bytes) -> Any:
    """Return what a line of JSON holds, or raise `InputError` if it is too long or holds something else."""
    if len(line) > MAX_LINE:
        raise InputError(f"expected at most {MAX_LINE:,} bytes in a line, found more")
    return read_json(line)


def read_observation(line: bytes) -> ObservationMessage:
    """Return the observation that a line holds.

    Raises
    ------
    InputError
        If it is none; the message names the field.
    """
    data = json_of_line(line)
    try:
        return ObservationMessage.model_validate(data)
    except ValidationError as error:
        field, said = wrong_field(error, data, _known_keys())
        raise InputError(said, field=field or None) from None


@cache
def _known_keys() -> set[str]:
    """Return the keys that an observation may have anywhere."""
    return keys_of_schema(ObservationMessage.model_json_schema())
