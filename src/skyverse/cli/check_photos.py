"""Photos that were taken, as ``check`` takes them: what they show of the surveys of a mission, and what is missing."""

import itertools
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import Group, Parameter

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.outputs import refuse_output
from skyverse.cli.plan import FleetOptions, MissionOutput, PlannerOptions, plan_scenario
from skyverse.cli.report import json_text, table
from skyverse.errors import InputError
from skyverse.model.short_lines import counted, listed, told_area, told_gsd, told_overlap, told_share

if TYPE_CHECKING:
    from skyverse.model.coverage import Coverage, CoverageGap
    from skyverse.model.photos import Photos
    from skyverse.model.scenario import Scenario

MOST_TOLD = 10
"""Gaps at most that are told of each survey."""
TIMES = 3
"""How often a reflight is planned anew of what it would leave open."""


@Parameter(name="*", group=Group("Photos that were taken"))
@dataclass(frozen=True, kw_only=True)
class PhotoOptions:
    """How photos are judged.

    Parameters
    ----------
    survey
        The mission, or the scenario, whose surveys photos are of, which are given in place of missions, in the order in
        which they were taken.
    reflight
        The mission to write that takes the photos that are missing, with its page.
    position_error
        Metres by which the positions of photos may be off; 0 when left out.
    """

    survey: str | None = None
    reflight: Path | None = None
    position_error: float | None = None


def check_photos(files: Sequence[str], survey: str, asked: PhotoOptions, altitude: Any, *, as_json: bool) -> int:
    """Judge photos by the surveys of a mission or scenario, and plan those that are missing, if asked."""
    import skyverse as sky

    reflight, error = asked.reflight, asked.position_error or 0.0
    source = sky.read(survey)
    world = source.scenario if isinstance(source, sky.Mission) else source
    if not isinstance(world, sky.Scenario) or not world.surveys:
        raise InputError(f"--survey: {survey}: expected a mission or a scenario with surveys, found none")
    if world.frame.origin is None:
        raise InputError(f"--survey: {survey}: expected a scenario with an origin, to place photos, found none")
    if reflight is not None:
        refuse_output(reflight, *files, survey)
    origin = world.frame.origin
    photos = reduce(
        lambda one, more: one.joined(more), (sky.read_photos(file, origin, altitude=altitude) for file in files)
    )
    found = sky.check_photos(world, photos, position_error=error)
    twice = len(photos) - found[0].photos - sum(map(len, found[0].left_out.values()))
    if twice:
        print(f"{counted(twice, 'photo')} equal others in place and direction, and do not count.", file=sys.stderr)
    for why, names in found[0].left_out.items():
        never = [name for name in names if all(name in itertools.chain(*one.left_out.values()) for one in found)]
        if never:
            more = [f"{len(never) - MOST_TOLD} more"] if len(never) > MOST_TOLD else []
            told = listed([*never[:MOST_TOLD], *more])
            print(f"{counted(len(never), 'photo')} left out, {why}: {told}", file=sys.stderr)
    if as_json:
        print(json_text([_data(one) for one in found]), end="")
    else:
        _tell(world, found)
    missing = any(one.verdict is not sky.Verdict.PROVEN for one in found)
    if missing and reflight is not None:
        again = world_without(world, photos, found, error)
        print(f"{len(again.surveys)} parts are planned again.", file=sys.stderr)
        written, fleet = MissionOutput(output=reflight), FleetOptions(criterion="min-max")
        with redirect_stdout(sys.stderr if as_json else sys.stdout):
            plan_scenario(again, survey, written, PlannerOptions(planner="taut"), fleet)
    elif reflight is not None:
        print(f"Nothing is missing: {reflight} is not written.", file=sys.stderr)
    return FOUND_WRONG if missing else 0


def world_without(world: "Scenario", photos: "Photos", found: "Sequence[Coverage]", error: float) -> "Scenario":
    """Return a scenario of surveys of what is missing, planned until nothing is."""
    import skyverse as sky

    again = world.model_copy(update={"targets": (), "surveys": (), "name": f"{world.name} again"})
    for time in range(TIMES):
        more = [
            one for part, own in zip(found, world.surveys, strict=True) for one in own.without(part, photos.direction)
        ]
        if not more:
            break
        more = [one.model_copy(update={"name": f"{one.name}.{time}" if time else one.name}) for one in more]
        again = again.model_copy(update={"surveys": (*again.surveys, *more)})
        found = sky.check_photos(
            world, photos.joined(sky.photos_of(sky.plan_mission(again, rng=1))), position_error=error
        )
    return again


def _data(one: "Coverage") -> dict[str, Any]:
    """Return a coverage as JSON has it, with nulls for numbers that there are none of."""
    known = {name: None if value != value else value for name, value in asdict(one).items()}
    overlap = [None if share != share else share for share in one.overlap]
    return known | {"verdict": one.verdict.value, "overlap": overlap}


def _tell(world: "Scenario", found: "Sequence[Coverage]") -> None:
    """Print what photos show of each survey, and the gaps."""
    for one in found:
        print(f"{world.surveys[one.survey].name}: {one.sentence}")
        along, between = map(told_overlap, one.overlap)
        rows = [
            ["photos", str(one.photos)],
            [f"seen by 1 to {len(one.seen)} photos", ", ".join(map(told_share, one.seen))],
            ["worst GSD", f"{told_gsd(one.gsd)}, 95 % of it {told_gsd(one.gsd_95)}"],
            ["least overlap", f"{along} along strips, {between} between them"],
            ["less than asked", f"{one.short} of {one.pairs} pairs"],
        ]
        table(("what was judged", "found"), rows)
        if one.gaps:
            table(("gap at", "area", "why"), [_row(world, gap) for gap in one.gaps[:MOST_TOLD]])
        if len(one.gaps) > MOST_TOLD:
            print(f"... and {len(one.gaps) - MOST_TOLD} more gaps")


def _row(world: "Scenario", gap: "CoverageGap") -> list[str]:
    """Return where a gap is, by its middle, how large it is, and why."""
    from skyverse.model.geodesy import told_place

    return [told_place(world.frame.origin, gap.middle), told_area(gap.area), gap.why]
