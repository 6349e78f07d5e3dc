"""Missions among zones with active times, which can be exported where no flight depends on these times."""

from collections.abc import Sequence
from dataclasses import replace

from skyverse.errors import InputError
from skyverse.model.mission import Mission
from skyverse.model.short_lines import listed
from skyverse.model.temporary_zones import temporary_zones, told_zone, with_zones_active
from skyverse.model.verdict import Certificate, Verdict
from skyverse.referee import certify


def with_zones_always_active(
    mission: Mission, what: str, certificates: Sequence[Certificate | None] | None = None
) -> Mission:
    """Return a mission in whose scenario all zones are active at all times, to prove legs and returns in.

    The zones of that scenario have other numbers, or are obstacles: what is said of the mission as given is said first.

    Parameters
    ----------
    mission
        The mission as given.
    what
        What would be made of it.
    certificates
        What the referee proves of each UAV's trajectory as given, if it has been asked; the mission's own are not
        believed.

    Raises
    ------
    InputError
        If a flight keeps clear of a zone, or to its speed limit, by its schedule alone.
    """
    given = mission.scenario
    numbers = temporary_zones(given)
    if not numbers:
        return mission
    lasting = replace(mission, scenario=with_zones_active(given, numbers))
    now = certify(given, mission).trajectories if certificates is None else certificates
    always = certify(lasting.scenario, lasting)
    for uav, (before, after) in enumerate(zip(now, always.trajectories, strict=True)):
        if before is None or after is None or before.verdict is not Verdict.PROVEN:
            continue
        if after.verdict is not Verdict.PROVEN:
            zones = listed([told_zone(given, number) for number in numbers if not _keeps_to(mission, uav, number)])
            raise InputError(
                f"{what}: {given.uavs[uav].name} keeps to the rules of {zones} by its schedule alone, and no autopilot "
                "keeps a schedule exactly enough; formats that keep the times of the flight hold it, such as .csv, "
                ".geojson and ROS's"
            )
    return replace(lasting, certificates=always.trajectories, apart=always.apart)


def _keeps_to(mission: Mission, uav: int, zone: int) -> bool:
    """Tell whether it is proven that a UAV would keep to the rules of a zone if that were always active."""
    scenario = with_zones_active(mission.scenario, {zone})
    certificate = certify(scenario, replace(mission, scenario=scenario)).trajectories[uav]
    return certificate is not None and certificate.verdict is Verdict.PROVEN
