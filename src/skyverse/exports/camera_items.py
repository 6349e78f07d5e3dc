"""MAVLink's items for photos: the camera made ready, the gimbal turned, photos by distance, by time or one by one.

The gimbal is told by MAV_CMD_DO_MOUNT_CONTROL (205), which every ArduPilot takes in missions and PX4 takes for gimbals
of either protocol; MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW (1000) ArduPilot takes only since 4.3. Single photos are taken by
MAV_CMD_DO_DIGICAM_CONTROL (203), since that triggers the same camera as MAV_CMD_DO_SET_CAM_TRIGG_DIST (206) in both.
Photos by time are those of MAV_CMD_IMAGE_START_CAPTURE (2000), of which ArduPilot knows a count since 4.4, and which
PX4 passes on to a camera that speaks MAVLink.
"""

from collections.abc import Iterator

from skyverse.errors import InputError
from skyverse.exports.autopilots import LOOKS
from skyverse.exports.flight_plan import FlightPlan, attainable_speed
from skyverse.exports.photo_strips import PhotoRun
from skyverse.orders.mavlink_items import MISSION_FRAME, Command, StoredItem

PHOTO_SURVEY = 2.0
"""CAMERA_MODE_IMAGE_SURVEY."""
TARGETED = 2.0
"""MAV_MOUNT_MODE_MAVLINK_TARGETING."""
LATE = 0.6
"""Metres by which the last photo of a run would come late where it is taken standing, lest it is taken twice."""
SAME_SPEED = 1.005
"""By which factor the speeds of a run may differ whose photos are taken by time."""


def camera_off(plan: FlightPlan) -> Iterator[StoredItem]:
    """Yield items that make a camera ready and stop all photos, whatever an earlier flight has left on."""
    runs = plan.route.runs
    if not runs:
        return
    if plan.autopilot.name == "px4":  # ArduPilot takes no camera mode in missions
        yield _item(Command.CAMERA_MODE, 0.0, PHOTO_SURVEY)
    yield _item(Command.PHOTO_DISTANCE)
    if any(run.trigger == "time" for run in runs):
        yield _item(Command.STOP_PHOTOS)


class CameraOrders:
    """What the camera of a flight is told before and after each of its waypoints, asked for in their order."""

    def __init__(self, plan: FlightPlan) -> None:
        self.plan = plan
        self.pitch: float | None = None

    def before(self, k: int) -> Iterator[StoredItem]:
        """Yield what is told before the leg to waypoint k: where the camera looks there."""
        for run in self.plan.route.runs:
            if run.on == k and run.pitch != self.pitch:
                self.pitch = run.pitch
                yield _item(Command.GIMBAL, run.pitch, 0.0, 0.0, 0.0, 0.0, 0.0, TARGETED)

    def after(self, k: int) -> Iterator[StoredItem]:
        """Yield what is told at waypoint k: that the photos of one run end, and that those of another begin."""
        if not k:
            yield from self.before(k)
        runs = self.plan.route.runs
        for run in runs:
            if run.off == k and run.on < k and not any(one.on == k and not one.standing_at(k) for one in runs):
                yield _item(Command.STOP_PHOTOS if run.trigger == "time" else Command.PHOTO_DISTANCE)
        for run in runs:
            if run.standing_at(k):
                yield _item(Command.PHOTO, 0.0, 0.0, 0.0, 0.0, 1.0)
            elif run.on == k and run.trigger == "time":
                yield _item(Command.START_PHOTOS, 0.0, interval(self.plan, run), float(run.count))
            elif run.on == k:
                yield _item(Command.PHOTO_DISTANCE, spacing(self.plan, run), 0.0, 1.0)


def look_late(plan: FlightPlan, run: PhotoRun) -> float:
    """Return the metres by which an autopilot takes a photo late in the mean, as it looks only now and then."""
    return LOOKS[plan.autopilot.name] / 2 * sum(paces := _paces(plan, run)) / len(paces)


def spacing(plan: FlightPlan, run: PhotoRun) -> float:
    """Return the metres between the photos of a run that an autopilot is told, by as much less as they are late."""
    late = LATE / (run.count - 1) if run.stands else 0.0
    return round(run.every + late - look_late(plan, run), 3)


def interval(plan: FlightPlan, run: PhotoRun) -> float:
    """Return the seconds between the photos of a run that are taken by time; raise `InputError` if its speed varies."""
    paces = _paces(plan, run)
    if max(paces) > SAME_SPEED * min(paces):
        raise InputError(
            f"photos by time need a steady speed, and strip {run.strip + 1} is flown at {min(paces):.3g} to "
            f"{max(paces):.3g} m/s; take them by distance"
        )
    return round(run.every / paces[0], 3)


def _paces(plan: FlightPlan, run: PhotoRun) -> list[float]:
    """Return the speeds of the legs of a run, m/s."""
    points, rates = plan.waypoints, plan.rates
    return [attainable_speed(points[k], points[k + 1], float(plan.speeds[k]), rates) for k in range(run.on, run.off)]


def _item(command: Command, *numbers: float) -> StoredItem:
    return StoredItem(command, MISSION_FRAME, (*numbers, *[0.0] * (7 - len(numbers))))
