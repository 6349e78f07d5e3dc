"""What `build_scenario` is given, documented once: for callers in Python and for the options of the command line."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from skyverse.errors import InputError, require_flag, require_kind, require_number, require_row, shown
from skyverse.maps.georeference.reading import Raster, Reading
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude, GlobalPlace
from skyverse.model.vehicle_profiles import FleetLimits

if TYPE_CHECKING:
    from skyverse.model.frame import Origin

GlobalPlaces = Mapping[str, GlobalPlace] | Sequence[GlobalPlace]
"""Places with names, or without."""
MAX_NUMBER = 1e6
"""The largest length or weight, metres, that is taken for one."""


@dataclass(frozen=True)
class Note:
    """What was done with a file, in words.

    Attributes
    ----------
    file
        Its path, or ``""`` for what is of no single file.
    text
        What was done.
    heed
        Whether a pilot must heed it. What begins with a `Caution` must be heeded, too, and stays with the scenario.
    """

    file: str
    text: str
    heed: bool = False


@dataclass(frozen=True, kw_only=True)
class MapFiles:
    """The files and places that a scenario is built of.

    Attributes
    ----------
    terrain
        Rasters of ground heights: GeoTIFF, ASCII grid, .hgt and others that rasterio reads.
    buildings
        Files of buildings, which must not be entered: CityJSON, OpenStreetMap, GeoJSON, KML, Shapefile, GeoPackage.
    zones
        Files, of the same formats, of zones that must not be entered.
    zones_closed_above
        Forbid to fly over the zones of files, too. When left out, their upper limits are those that the files state.
    soft_zones
        Files of zones that may be flown through, each with the risk of a metre flown inside, where no field ``risk``
        says it.
    fences
        Files, of the same formats, of areas that UAVs must stay in: all outside of every one of them is forbidden, at
        any height. Heights in these files do not count.
    max_heights
        Files, of the same formats, of cells that say how high above ground flight is permitted, such as the FAA's UAS
        facility maps: all above that is forbidden, counted from the lowest ground below a cell or a part of it. Where
        cells overlap the lower height counts; outside of all cells nothing is said.
    voxels
        Point clouds, .las or .laz, that say where on Earth they lie and were taken from the air: what is below a point
        counts as occupied. Points of noise are left out, and those of the ground where there is a terrain.
    uavs
        Where each UAV starts: latitude and longitude (WGS84 degrees) and altitude, in order or by name. A UAV's home
        is the ground below its start as the terrain's files have it, before it is raised.
    targets
        The places that must be reached, given as those of UAVs.
    licences
        The licence of a file that does not say it itself, by the file as given, or by its name where only one file has
        it. It is kept in the scenario.
    """

    terrain: Sequence[Raster | str | Path] = ()
    buildings: Sequence[str | Path] = ()
    zones: Sequence[str | Path] = ()
    zones_closed_above: bool = False
    soft_zones: Sequence[tuple[str | Path, float]] = ()
    fences: Sequence[str | Path] = ()
    max_heights: Sequence[str | Path] = ()
    voxels: Sequence[str | Path] = ()
    uavs: GlobalPlaces = ()
    targets: GlobalPlaces = ()
    licences: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        require_flag(self.zones_closed_above, "zones_closed_above")
        for name in ("uavs", "targets"):
            require_kind(getattr(self, name), (list, tuple, Mapping), name)
        for name in ("terrain", "buildings", "zones", "fences", "max_heights", "voxels", "soft_zones"):
            require_kind(getattr(self, name), (list, tuple), name)
            for number, one in enumerate(getattr(self, name)):
                if name == "soft_zones":
                    require_kind(one, (list, tuple), f"soft_zones[{number}]")
                    one, risk = one if len(one) == 2 else (one, None)
                    require_number(risk, f"soft_zones[{number}]", "a file and a risk")
                require_kind(one, (str, Path, Raster) if name == "terrain" else (str, Path), f"{name}[{number}]")
        if self.licences is not None:
            require_kind(self.licences, Mapping, "licences")
            for file, text in self.licences.items():
                require_kind(file, (str, Path), "licences")
                require_kind(text, str, "licences")


@dataclass(frozen=True, kw_only=True)
class MapRegion:
    """The part of the world that a scenario holds, and the frame in which it holds it.

    Attributes
    ----------
    area
        West, south, east and north, degrees; what lies outside is dropped. When left out, the area is what lies within
        `margin` of UAVs, targets and `around`, or, where there are none, the box around the fence, or else all that the
        terrain or the buildings cover.
    around
        Files of areas and lines, such as what is to be surveyed, that the area holds besides UAVs and targets: KML,
        GeoJSON, Shapefile, GeoPackage; or places, latitude and longitude.
    margin
        Without an area, how much is kept around UAVs, targets and `around`, metres; 250 when left out.
    origin
        The zero of the local frame; the middle of the area, at its lowest ground, when left out.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres; ellipsoidal heights and some exports need
        it.
    ground
        Without a terrain, the altitude of level ground.
    ceiling
        How high UAVs may fly: above the ground below them, the same as `max_height`, or above the sea, where the bounds
        end. When left out, the bounds end 30 m above the highest of ground, buildings, UAVs, targets and the beginnings
        of zones up to 152.4 m above them.
    max_height
        How high above the ground below UAVs may fly: a ceiling that follows the terrain. Without a `ceiling` above the
        sea, the bounds reach as high above the highest ground.
    """

    area: tuple[float, float, float, float] | None = None
    around: Sequence[str | Path | tuple[float, float]] = ()
    margin: float | None = None
    origin: "Origin | None" = None
    geoid: float | None = None
    ground: AboveSea | None = None
    ceiling: Altitude | None = None
    max_height: AboveGround | None = None

    def __post_init__(self) -> None:
        from skyverse.model.frame import Origin, require_geoid  # which imports pydantic; help has no need of it

        _require(0.0, margin=self.margin)
        if self.area is not None:
            require_row(self.area, 4, "area")
        require_kind(self.around, (list, tuple), "around")
        for number, one in enumerate(self.around):
            require_kind(one, (str, Path, tuple), f"around[{number}]")
            if isinstance(one, tuple):
                require_row(one, 2, f"around[{number}]")
        if self.geoid is not None:
            require_geoid(self.geoid)
        if isinstance(self.ceiling, AboveHome):
            raise InputError("expected agl (above the ground below) or amsl, found home", field="ceiling")
        for name, kinds in (
            ("origin", (Origin,)),
            ("ground", (AboveSea,)),
            ("ceiling", (AboveSea, AboveGround)),
            ("max_height", (AboveGround,)),
        ):
            if getattr(self, name) is not None:
                require_kind(getattr(self, name), kinds, name)


@dataclass(frozen=True, kw_only=True)
class MapDetail:
    """The clearances, steps and tolerances of a scenario.

    Attributes
    ----------
    clearance
        How far UAVs stay away from obstacles, metres; 5 when left out.
    ground_clearance
        How far UAVs stay above ground, metres; 30 when left out, as maps of the ground know no trees, masts and wires.
    band
        The lowest and the highest height above ground, metres, between which paths keep where it pays.
    band_weight
        The price of a metre flown a metre outside the band.
    lattice_step
        The step of the lattice, metres; when left out, the shortest of 1, 2, 5, 10 ... that makes at most two million
        nodes. Below a ceiling above ground it is at most five million, and upright no more than half of the height that
        UAVs may use.
    terrain_step
        How far apart the ground's heights are, metres; about as far as in the finest raster when left out.
    voxel_size
        How long the voxels of point clouds are, metres; when left out, 2, or more for at most eight million voxels.
        It should exceed the gaps between points.
    tolerance
        By how much outlines may grow to lose corners, metres; with 0 they stay as they are.
    fill_nodata
        What stands for the ground where rasters have no data: metres above mean sea level, or the nearest height. Such
        holes are refused when left out.
    """

    clearance: float = 5.0
    ground_clearance: float = 30.0
    band: tuple[float, float] | None = None
    band_weight: float = 0.1
    lattice_step: float | None = None
    terrain_step: float | None = None
    voxel_size: float | None = None
    tolerance: float = 0.5
    fill_nodata: float | Literal["nearest"] | None = None

    def __post_init__(self) -> None:
        from skyverse.model.shapes import LEAST_CLEARANCE  # which imports numpy; help has no need of it

        for name, least in (
            ("clearance", LEAST_CLEARANCE),
            ("ground_clearance", LEAST_CLEARANCE),
            ("tolerance", 0.0),
            ("band_weight", 1e-3),
        ):
            require_number(getattr(self, name), name, least=least, most=MAX_NUMBER)
        _require(1e-3, lattice_step=self.lattice_step, terrain_step=self.terrain_step, voxel_size=self.voxel_size)
        if self.band is not None:
            require_row(self.band, 2, "band")
        _require(-1000.0, fill_nodata=None if self.fill_nodata == "nearest" else self.fill_nodata)


@dataclass(frozen=True)
class BuildOptions(FleetLimits, MapDetail, MapRegion, MapFiles):
    """All that `build_scenario` is given.

    Attributes
    ----------
    name
        The scenario's name.
    reading
        How files of buildings, zones and points are read where they leave it open.
    on_note
        Called with a `Note` on each thing that is done, as it is done.
    """

    name: str
    _: KW_ONLY
    reading: Reading | None = None
    on_note: Callable[[Note], object] = lambda note: None

    def __post_init__(self) -> None:
        require_kind(self.name, str, "name")
        for part in (MapFiles, MapRegion, MapDetail, FleetLimits):
            part.__post_init__(self)
        if self.reading is not None:
            require_kind(self.reading, Reading, "reading")
        if not callable(self.on_note):
            raise InputError(f"expected a function, found {shown(self.on_note)}", field="on_note")
        if isinstance(self.ceiling, AboveGround):  # one idea: a ceiling above ground follows it
            if self.max_height is not None and self.max_height != self.ceiling:
                raise InputError(
                    f"expected it above the sea beside a greatest height above ground, found {self.ceiling.metres:g} m "
                    f"above ground and {self.max_height.metres:g} m",
                    field="ceiling",
                )
            object.__setattr__(self, "max_height", self.ceiling)
            object.__setattr__(self, "ceiling", None)


def _require(least: float, **numbers: float | None) -> None:
    """Raise `InputError` for a number that is too small or too large."""
    for name, value in numbers.items():
        if value is not None:
            require_number(value, name, least=least, most=MAX_NUMBER)
