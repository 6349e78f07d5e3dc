"""Rasters of heights as files have them: opened, checked, and read in windows, never whole where a part will do."""

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.maps.readers.gaps import blocks, refuse_gaps
from skyverse.maps.readers.smooth import Smooth
from skyverse.model.altitude import FOOT
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.scenario import Origin

if TYPE_CHECKING:
    from pyproj import CRS


UNITS = {"m": 1.0, "ft": FOOT, "us-ft": 1200 / 3937}
"""Metres to each."""
_SPELT = {
    **dict.fromkeys(("", "m", "metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("ft", "foot", "feet", "international foot"), "ft"),
    **dict.fromkeys(("us-ft", "ussft", "ftus", "us survey foot", "us survey feet", "foot_us"), "us-ft"),
}
_NO_HEIGHT = (-32768.0, -32767.0, -9999.0, 32767.0, 65535.0)
"""What files write for no data, and sometimes forget to declare."""
DEEPEST, HIGHEST = -11_000.0, 9_000.0
LOWEST = -500.0
"""Metres that no land lies below; the shore of the Dead Sea lies at -430 and sinks."""


@dataclass(frozen=True)
class Raster:
    """A file of ground heights that rasterio can read, and what it does not say itself.

    Attributes
    ----------
    path
        GeoTIFF, ASCII grid, .hgt and others.
    crs
        The coordinates that it is in, such as ``"EPSG:2056"``, where the file does not say.
    band
        Which band holds the heights, from 1 on; needed where there are several.
    unit
        ``"m"``, ``"ft"`` or ``"us-ft"``, in place of what the file says; metres where neither says.
    nodata
        The number that stands for no data, beside what the file says; ``nan`` where none does, and every number is a
        height.
    """

    path: str | Path
    crs: str | None = None
    band: int | None = None
    unit: str | None = None
    nodata: float | None = None


def tools() -> tuple[Any, Any]:
    """Return rasterio and pyproj, or say how they are installed."""
    try:
        import pyproj
        import rasterio
    except ImportError:
        raise InputError('reading terrain needs rasterio and pyproj: pip install "skyverse[maps]"') from None
    return rasterio, pyproj


class Opened:
    """A raster that is open, with heights in metres and a way between its pixels and the globe."""

    def __init__(self, raster: Raster, data: Any) -> None:
        from skyverse.maps.georeference import datum

        self.path, self.data = str(raster.path), data
        self.nodata = raster.nodata
        self.band = self._which(raster.band)
        self.crs, metres, self.ellipsoidal = self._where(raster.crs)
        said = raster.unit if raster.unit is not None else (data.units[self.band - 1] or "")
        if said.strip().lower() not in _SPELT:
            raise InputError(f"{self.path}: its heights are in {said!r}, not metres or feet; say which (m, ft, us-ft)")
        self.unit = UNITS[_SPELT[said.strip().lower()]]
        self.says_unit = said != "" or metres is not None
        if said == "" and metres is not None:
            self.unit = metres
        flat = self.crs.to_2d()
        middle = _moved(data.transform, np.array(data.width / 2), np.array(data.height / 2))
        self.globe, self.doubt = datum.to_globe(flat, float(middle[0]), float(middle[1]), self.path)
        self.turn = 2 * np.pi / flat.axis_info[0].unit_conversion_factor if flat.is_geographic else None
        if data.transform.determinant == 0 or data.transform.is_identity or min(data.shape) < 2:
            raise InputError(f"{self.path}: it does not say where on Earth its pixels lie (no geotransform)")

    @property
    def all_heights(self) -> bool:
        """Whether the user says that no number stands for no data."""
        return self.nodata is not None and math.isnan(self.nodata)

    def _which(self, band: int | None) -> int:
        count = self.data.count
        if band is None and count > 1:
            raise InputError(f"{self.path}: it has {count} bands; say which holds the heights, as in --terrain-band 1")
        if band is not None and not 1 <= band <= count:
            raise InputError(f"{self.path}: expected a band from 1 to {count}, found {band}")
        chosen = band or 1
        if "complex" in self.data.dtypes[chosen - 1]:
            raise InputError(f"{self.path}: band {chosen} holds complex numbers, not heights")
        return chosen

    def _where(self, given: str | None) -> tuple["CRS", float | None, bool]:
        """Return the coordinates, how many metres a vertical unit has, if known, and if heights are ellipsoidal."""
        from skyverse.maps.georeference import datum

        _, pyproj = tools()
        own = self.data.crs
        if own is None and given is None:
            raise InputError(f"{self.path}: it has no coordinate system; say it, as in --terrain-crs EPSG:4326")
        try:
            crs = pyproj.CRS.from_user_input(given if own is None else own.to_epsg() or own.to_wkt())
        except pyproj.exceptions.CRSError:
            shown = given if own is None else own.to_wkt()
            raise InputError(f"{self.path}: expected a coordinate system, found {shown!r:.60}") from None
        upward = datum.vertical(crs, self.path)
        if crs.is_compound:
            crs = crs.sub_crs_list[0]
        if not (crs.is_geographic or crs.is_projected):
            raise InputError(f"{self.path}: its coordinate system, {crs.name!r}, does not lie on Earth")
        return crs, *(upward or (None, False))

    @property
    def name(self) -> str:
        """The coordinate system, as ``EPSG:n`` where it has a number."""
        code = self.crs.to_authority()
        return ":".join(code) if code else str(self.crs.name)

    @property
    def licence(self) -> str:
        """What the file says of its copyright."""
        return str(self.data.tags().get("TIFFTAG_COPYRIGHT", ""))

    def places(self, columns: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Return longitudes and latitudes of pixel coordinates; a pixel's centre is at a half."""
        longitude, latitude = self.globe.transform(*_moved(self.data.transform, columns, rows))
        return np.asarray(longitude), np.asarray(latitude)

    def pixels(self, longitude: Floats, latitude: Floats, around: float, turns: int) -> tuple[Floats, Floats]:
        """Return pixel coordinates of places; longitudes are those nearest to `around`, turned that often."""
        first, second = self.globe.transform(longitude, latitude, direction="INVERSE")
        if self.turn is not None:
            middle = around * self.turn / 360
            first = middle + (first - middle + self.turn / 2) % self.turn - self.turn / 2 + turns * self.turn
        return _moved(~self.data.transform, np.asarray(first), np.asarray(second))

    def pixel(self, latitude: float, longitude: float) -> tuple[float, float] | None:
        """Return the pixel coordinates of a place, or ``None`` where it is outside."""
        for turns in (0,) if self.turn is None else (-1, 0, 1):
            at = self.pixels(np.array([longitude]), np.array([latitude]), longitude, turns)
            column, row = float(at[0][0]), float(at[1][0])
            if 0 <= column <= self.data.width and 0 <= row <= self.data.height:
                return column, row
        return None

    def height(self, latitude: float, longitude: float) -> float:
        """Return the height at a place, metres, bilinear between pixels' centres; ``nan`` outside and beside holes."""
        at = self.pixel(latitude, longitude)
        if at is None:
            return math.nan
        x, y = (min(max(c - 0.5, 0.0), n - 1.0) for c, n in zip(at, (self.data.width, self.data.height), strict=True))
        i, j = min(int(x), self.data.width - 2), min(int(y), self.data.height - 2)
        u, v = x - i, y - j
        near = self.heights(i, j, 2, 2)
        return float(np.array([1 - v, v]) @ near @ np.array([1 - u, u]))

    def heights(self, column: int, row: int, columns: int, rows: int) -> Floats:
        """Return a window's heights in metres, ``nan`` where there is none."""
        rasterio, _ = tools()
        window = rasterio.windows.Window(column, row, columns, rows)
        try:
            with np.errstate(invalid="ignore"):  # of numbers that are none
                raw = self.data.read(self.band, window=window, masked=True)
                values: Floats = np.ma.getdata(raw).astype(np.float64)
        except rasterio.errors.RasterioError as error:
            raise InputError(f"{self.path}: cannot be read, it is cut off or damaged: {_first(error)}") from None
        holes = np.ma.getmaskarray(raw) | ~np.isfinite(values)
        if self.nodata is not None:
            with np.errstate(over="ignore"):  # -9999.9 is another number in four bytes
                holes |= values == (np.float32(self.nodata) if raw.dtype == np.float32 else self.nodata)
        odd = np.isin(values, _NO_HEIGHT) & ~holes & (not self.all_heights)
        values = (values * self.data.scales[self.band - 1] + self.data.offsets[self.band - 1]) * self.unit
        odd |= (values < LOWEST) & (values >= DEEPEST) & ~holes & (not self.all_heights)
        wild = ~holes & ((values < DEEPEST) | (values > HIGHEST)) & ~odd
        for bad, what in ((odd, "which is hardly a height"), (wild, "which is nowhere on Earth")):
            if bad.any():
                k, m = np.argwhere(bad)[0]
                value = float(values[k, m])
                share = float((values == value).mean())
                self.refuse_height(value, share, (column + m + 0.5, row + k + 0.5), what, wild=bad is wild)
        values[holes] = np.nan
        return values

    def refuse_height(
        self, height: float, share: float, pixel: tuple[float, float], why: str, *, wild: bool = False
    ) -> NoReturn:
        """Refuse a height in metres, which so much of what was read has, as at a pixel."""
        number = (height / self.unit - self.data.offsets[self.band - 1]) / self.data.scales[self.band - 1]
        single = self.data.dtypes[self.band - 1] == "float32"
        said = str(np.float32(number)).removesuffix(".0") if single else f"{number:.12g}"
        longitude, latitude = self.places(*(np.array([at]) for at in pixel))
        metres = "" if math.isclose(float(said), height, rel_tol=1e-6) else f" ({height:g} m)"
        raise InputError(
            f"{self.path}: it holds {said}{metres}, {why}, in {100 * share:.3g}% of the pixels looked at, such as at "
            f"latitude {latitude[0]:.6f}, longitude {longitude[0]:.6f}; if it stands for no data, say --nodata {said}, "
            + ("else check its unit (--terrain-unit)" if wild else "if it is a height, --nodata nan")
        )


def _moved(transform: Any, first: Floats, second: Floats) -> tuple[Floats, Floats]:
    """Apply a geotransform."""
    a, b, c, d, e, f = transform[:6]
    with np.errstate(invalid="ignore", over="ignore"):  # a place that is nowhere on a map is infinitely far away
        return a * first + b * second + c, d * first + e * second + f


@contextmanager
def opened(raster: Raster) -> Iterator[Opened]:
    """Open a raster, or raise `InputError`."""
    rasterio, _ = tools()
    path = Path(raster.path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    _require_own(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        warnings.simplefilter("ignore", RuntimeWarning)  # of numbers for no data that are none
        try:
            data = rasterio.open(path)
        except (rasterio.errors.RasterioError, rasterio.errors.CRSError, UnicodeError) as error:
            raise InputError(
                f"{path}: expected a raster such as a GeoTIFF, found it cut off or something else: {_first(error)}"
            ) from None
        with data:
            yield Opened(raster, data)


def _require_own(path: Path) -> None:
    """Refuse a file that names others, some of them on servers, which GDAL would open."""
    with path.open("rb") as file:
        text = file.read(256).removeprefix(b"\xef\xbb\xbf").lstrip()
    if text[:1] in (b"<", b"{") or ".gti" in path.suffixes:
        raise InputError(
            f"{path}: expected a raster such as a GeoTIFF, found what only points to others (such as a .vrt); "
            "give those themselves, several may follow one option"
        )


def _first(error: BaseException) -> str:
    return (str(error.__cause__ or error).strip().splitlines() or [type(error).__name__])[0]


LEVELS = (0.0, 4000.0)
"""Two altitudes; what lies between them or beyond is straight enough on a line through them."""


@dataclass(frozen=True)
class Tile:
    """A window of a raster, and how it lies in the local frame whose origin is at altitude 0.

    Attributes
    ----------
    heights
        (rows, columns) metres above sea level, ``nan`` where there is none. Where `block` is above 1, the greatest
        of so many by so many pixels.
    corner
        Column and row of the first pixel.
    block
        How many pixels wide and high what a height stands for is.
    local
        Column and row to local metres at sea level, and to how far they move for each metre of height: 6 numbers.
    pixel
        x and y to column, row and altitude, at both `LEVELS` of z: 6 numbers.
    """

    heights: Floats
    corner: tuple[int, int]
    block: int
    local: Smooth
    pixel: Smooth


Rectangle = tuple[float, float, float, float]
"""The least x and y, the greatest x and y, metres."""
DIRECT, POOLED = 8e6, 2e6
"""Pixels that are looked at one by one, at most; and what is left of more, where the step allows."""


def tiles(opened: Opened, origin: Origin, region: Rectangle, step: float) -> list[Tile]:
    """Return what a raster has over a region of the local frame; a raster on the globe may reach it twice."""
    x0, y0, x1, y1 = region
    found = []
    for turns in (0,) if opened.turn is None else (-1, 0, 1):

        def pixel(x: Floats, y: Floats, turns: int = turns) -> Floats:
            rows: list[Floats] = []
            for z in LEVELS:
                latitude, longitude, altitude = to_wgs84(origin, np.column_stack([x, y, np.full_like(x, z)])).T
                rows += [*opened.pixels(longitude, latitude, origin.longitude, turns), altitude]
            return np.array(rows)

        to_pixel = Smooth(pixel, (x0, x1), (y0, y1))
        reach = to_pixel.grid(np.linspace(x0, x1, 33), np.linspace(y0, y1, 33))
        if not np.isfinite(reach).all():
            raise InputError(f"{opened.path}: its coordinate system, {opened.name}, does not reach the area")
        across, down = reach[[0, 3]], reach[[1, 4]]
        width, height = opened.data.width, opened.data.height
        left, right = max(0, int(across.min()) - 3), min(width, int(across.max()) + 4)
        top, bottom = max(0, int(down.min()) - 3), min(height, int(down.max()) + 4)
        if left >= right or top >= bottom:
            continue

        def local(columns: Floats, rows: Floats) -> Floats:
            longitude, latitude = opened.places(columns, rows)
            if not (np.isfinite(longitude).all() and np.isfinite(latitude).all()):
                raise InputError(f"{opened.path}: its coordinate system, {opened.name}, does not reach its pixels")
            low, high = (
                to_local(origin, np.column_stack([latitude, longitude, np.full_like(latitude, level)]))
                for level in LEVELS
            )
            return np.concatenate([low.T, (high - low).T / (LEVELS[1] - LEVELS[0])])

        to_metres = Smooth(local, (left, right), (top, bottom))
        _refuse_crooked(opened, to_pixel, to_metres, region)
        pitch = _pitch(to_metres, (left, right), (top, bottom))
        block = _block((right - left) * (bottom - top), pitch, step)
        window = left, top, right - left, bottom - top
        heights = blocks(opened, window, block)
        refuse_gaps(opened, window, heights, block, pitch * block)
        if opened.ellipsoidal:
            if origin.geoid is None:
                raise InputError(
                    f"{opened.path}: its heights are counted from the ellipsoid; --geoid METRES says how far mean sea "
                    "level lies above it there"
                )
            heights -= origin.geoid
        found.append(Tile(heights, (left, top), block, to_metres, to_pixel))
    return found


def _block(pixels: int, pitch: float, step: float) -> int:
    wanted = 1 if pixels <= DIRECT else int(np.ceil(np.sqrt(pixels / POOLED)))
    return max(1, min(wanted, int(step / (1.5 * pitch))))


def pitch(opened: Opened, origin: Origin) -> float:
    """Return the longest side of a pixel near the origin, metres."""
    at = np.array([origin.longitude]), np.array([origin.latitude])
    column, row = opened.pixels(*at, origin.longitude, 0)
    longitude, latitude = opened.places(column + np.eye(3)[1], row + np.eye(3)[2])
    places = to_local(origin, np.column_stack([latitude, longitude, np.zeros(3)]))
    found = float(np.hypot(*(places[1:] - places[0])[:, :2].T).max())
    if not 0 < found < np.inf:
        raise InputError(f"{opened.path}: its coordinate system, {opened.name}, does not reach the area")
    return found


def _pitch(to_metres: Smooth, columns: tuple[int, int], rows: tuple[int, int]) -> float:
    """Return the longest side of a pixel, metres."""
    at = [np.linspace(low, high, 5) for low, high in (columns, rows)]
    places = to_metres.grid(*at)[:2]
    sides = [np.hypot(*np.diff(places, axis=1 + axis)).max() / (at[axis][1] - at[axis][0]) for axis in range(2)]
    return float(max(sides))


def _refuse_crooked(opened: Opened, to_pixel: Smooth, to_metres: Smooth, region: Rectangle) -> None:
    """Go from metres to pixels and back: where a pole lies in the region, that does not come out."""
    x0, y0, x1, y1 = region
    x, y = x0 + (x1 - x0) * _PROBES, y0 + (y1 - y0) * _PROBES
    column, row, altitude = to_pixel.grid(x, y)[:3].reshape(3, -1)
    each, other = (at.ravel() for at in np.meshgrid(x, y, indexing="ij"))
    inside = (column > 0) & (column < opened.data.width) & (row > 0) & (row < opened.data.height)
    for k in np.flatnonzero(inside):
        base, lean = np.split(to_metres.grid(column[k : k + 1], row[k : k + 1])[:, 0, 0], 2)
        back = base + altitude[k] * lean
        if not np.hypot(back[0] - each[k], back[1] - other[k]) < 0.01:
            raise InputError(f"{opened.path}: its coordinate system, {opened.name}, is not smooth over the area")


_PROBES = np.array([0.13, 0.37, 0.61, 0.89])
