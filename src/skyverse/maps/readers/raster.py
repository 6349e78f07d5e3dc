"""Rasters of ground heights: files are opened, checked, and read window by window."""

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, first_line, require_file
from skyverse.extras import require_libraries
from skyverse.maps.georeference.reading import Raster
from skyverse.model.altitude import FOOT

if TYPE_CHECKING:
    from pyproj import CRS


METRES_PER_HEIGHT_UNIT = {"m": 1.0, "ft": FOOT, "us-ft": 1200 / 3937}
_SPELLINGS = {
    **dict.fromkeys(("", "m", "metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("ft", "foot", "feet", "international foot"), "ft"),
    **dict.fromkeys(("us-ft", "ussft", "ftus", "us survey foot", "us survey feet", "foot_us"), "us-ft"),
}
_USUAL_NODATA = (-32768.0, -32767.0, -9999.0, 32767.0, 65535.0)
"""Numbers that files write for no data, and sometimes forget to declare."""
WINDOW = 1024
"""Pixels along the sides of a window at most that is read for the heights of some places."""
LOWEST_ON_EARTH, HIGHEST_ON_EARTH = -11_000.0, 9_000.0
LOWEST_LAND = -500.0
"""Metres that no land lies below; the shore of the Dead Sea lies at -430 and sinks."""


class OpenRaster:
    """A raster that is open, with heights in metres and a way between its pixels and the globe.

    Attributes
    ----------
    path
        The file.
    data
        The data set of rasterio.
    band
        The number of the band that holds the heights, from 1 on.
    crs
        The coordinate system, horizontal or of three dimensions.
    ellipsoidal
        Whether heights are counted from the WGS84 ellipsoid.
    unit
        The metres in a unit of the heights.
    says_unit
        Whether the file or the user says that unit.
    globe
        The transformer to longitude and latitude.
    doubt
        What is doubtful about that transformer, or ``""``.
    turn
        A full turn in units of the coordinate system, ``None`` where it is not in angles.
    """

    def __init__(self, raster: Raster, data: Any) -> None:
        from skyverse.maps.georeference.coordinate_systems import transformer_to_globe

        self.path, self.data = str(raster.path), data
        self.nodata = raster.nodata
        self.band = self._band(raster.band)
        self.crs, metres, self.ellipsoidal = self._coordinates(raster.crs)
        said = raster.unit if raster.unit is not None else (data.units[self.band - 1] or "")
        if said.strip().lower() not in _SPELLINGS:
            units = [Remedy("Raster.unit", unit) for unit in METRES_PER_HEIGHT_UNIT]
            raise InputError(f"{self.path}: its heights are in {said!r}, not metres or feet", give=units)
        self.unit = METRES_PER_HEIGHT_UNIT[_SPELLINGS[said.strip().lower()]]
        self.says_unit = said != "" or metres is not None
        if said == "" and metres is not None:
            self.unit = metres
        flat = self.crs.to_2d()
        if not self.says_unit and flat.is_projected and flat.axis_info[0].unit_conversion_factor != 1:
            units = [Remedy("Raster.unit", unit) for unit in METRES_PER_HEIGHT_UNIT]
            raise InputError(f"{self.path}: {flat.name} is not in metres, and its heights have no unit", give=units)
        middle = _transformed(data.transform, np.array(data.width / 2), np.array(data.height / 2))
        self.globe, self.doubt = transformer_to_globe(flat, float(middle[0]), float(middle[1]), self.path)
        self.turn = 2 * np.pi / flat.axis_info[0].unit_conversion_factor if flat.is_geographic else None
        if data.transform.determinant == 0 or data.transform.is_identity or min(data.shape) < 2:
            raise InputError(f"{self.path}: it does not say where on Earth its pixels lie (no geotransform)")

    @property
    def all_heights(self) -> bool:
        """Whether the user says that every number is a height, and none stands for no data."""
        return self.nodata is not None and math.isnan(self.nodata)

    def _band(self, band: int | None) -> int:
        count = self.data.count
        if band is None and count > 1:
            held = Remedy("Raster.band", 1, "if the first holds the heights")
            raise InputError(f"{self.path}: it has {count} bands", give=[held])
        if band is not None and not 1 <= band <= count:
            raise InputError(f"{self.path}: expected a band from 1 to {count}, found {band}")
        chosen = band or 1
        if "complex" in self.data.dtypes[chosen - 1]:
            raise InputError(f"{self.path}: band {chosen} holds complex numbers, not heights")
        return chosen

    def _coordinates(self, given: str | None) -> tuple["CRS", float | None, bool]:
        """Return the coordinate system, the metres in a vertical unit, if known, and if heights are ellipsoidal."""
        import pyproj

        from skyverse.maps.georeference.coordinate_systems import unit_of_heights

        own = self.data.crs
        if own is None and given is None:
            raise InputError(f"{self.path}: it has no coordinate system", give=[Remedy("Raster.crs", "EPSG:4326")])
        try:
            crs = pyproj.CRS.from_user_input(given if own is None else own.to_epsg() or own.to_wkt())
        except pyproj.exceptions.CRSError:
            found = given if own is None else own.to_wkt()
            raise InputError(f"{self.path}: expected a coordinate system, found {found!r:.60}") from None
        upward = unit_of_heights(crs, self.path)
        if crs.is_compound:
            crs = crs.sub_crs_list[0]
        if not (crs.is_geographic or crs.is_projected):
            raise InputError(f"{self.path}: its coordinate system, {crs.name!r}, does not lie on Earth")
        return crs, *(upward or (None, False))

    @property
    def name(self) -> str:
        """The coordinate system's name, ``EPSG:n`` where it has a number."""
        code = self.crs.to_authority()
        return ":".join(code) if code else str(self.crs.name)

    @property
    def licence(self) -> str:
        """What the file says of its copyright, ``""`` where it says nothing."""
        return str(self.data.tags().get("TIFFTAG_COPYRIGHT", ""))

    def places(self, columns: Floats, rows: Floats) -> tuple[Floats, Floats]:
        """Return longitudes and latitudes of pixel coordinates; the first pixel's centre is at 0.5, 0.5."""
        longitude, latitude = self.globe.transform(*_transformed(self.data.transform, columns, rows))
        return np.asarray(longitude), np.asarray(latitude)

    def pixels(self, longitude: Floats, latitude: Floats, around: float | Floats, turns: int) -> tuple[Floats, Floats]:
        """Return the columns and rows of places.

        Parameters
        ----------
        longitude, latitude
            The places, degrees.
        around
            A longitude, or one for each; each place's own is taken at the full turn that is nearest to it.
        turns
            Full turns that are added to the longitudes then.
        """
        first, second = self.globe.transform(longitude, latitude, direction="INVERSE")
        if self.turn is not None:
            middle = around * self.turn / 360
            first = middle + (first - middle + self.turn / 2) % self.turn - self.turn / 2 + turns * self.turn
        return _transformed(~self.data.transform, np.asarray(first), np.asarray(second))

    def pixel(self, latitude: float, longitude: float) -> tuple[float, float] | None:
        """Return the column and row of a place, or ``None`` where the raster does not reach it."""
        for turns in (0,) if self.turn is None else (-1, 0, 1):
            at = self.pixels(np.array([longitude]), np.array([latitude]), longitude, turns)
            column, row = float(at[0][0]), float(at[1][0])
            if 0 <= column <= self.data.width and 0 <= row <= self.data.height:
                return column, row
        return None

    def heights_at(self, places: ArrayLike) -> Floats:
        """Return the heights (n,) at latitudes and longitudes (n, 2), metres; ``nan`` outside and beside holes.

        They are bilinear between pixels' centres.
        """
        latitude, longitude = np.asarray(places, dtype=np.float64).T
        size, found = np.array([[self.data.width], [self.data.height]]), np.full(len(latitude), np.nan)
        for turns in (0,) if self.turn is None else (-1, 0, 1):
            at = np.stack(self.pixels(longitude, latitude, longitude, turns))
            inside = np.flatnonzero(((at >= 0) & (at <= size)).all(axis=0))
            at = np.clip(at[:, inside] - 0.5, 0, size - 1)
            first = np.minimum(at.astype(np.int64), size - 2)
            for window in np.unique(first // WINDOW, axis=1).T:  # few windows are read sooner than many pixels
                some = np.flatnonzero((first // WINDOW == window[:, None]).all(axis=0))
                low, high = first[:, some].min(axis=1), first[:, some].max(axis=1) + 2
                heights = self.heights(*low.tolist(), *(high - low).tolist())
                (i, j), (u, v) = first[:, some] - low[:, None], at[:, some] - first[:, some]
                above, below = (heights[j + k, i] * (1 - u) + heights[j + k, i + 1] * u for k in (0, 1))
                found[inside[some]] = above * (1 - v) + below * v
        return found

    def heights(self, column: int, row: int, columns: int, rows: int) -> Floats:
        """Return the heights (rows, columns) of a window, metres, ``nan`` where the raster has no data.

        Raises
        ------
        InputError
            If the file is damaged, or a number is hardly a height.
        """
        import rasterio

        window = rasterio.windows.Window(column, row, columns, rows)
        try:
            with np.errstate(invalid="ignore"):  # NaN and infinity are holes
                raw = self.data.read(self.band, window=window, masked=True)
                values: Floats = np.ma.getdata(raw).astype(np.float64)
        except rasterio.errors.RasterioError as error:
            cause = first_line(error.__cause__ or error)
            raise InputError(f"{self.path}: cannot be read, it is cut off or damaged: {cause}") from None
        holes = np.ma.getmaskarray(raw) | ~np.isfinite(values)
        if self.nodata is not None:
            with np.errstate(over="ignore"):  # a float32 file holds the float32 nearest to -9999.9
                holes |= values == (np.float32(self.nodata) if raw.dtype == np.float32 else self.nodata)
        odd = np.isin(values, _USUAL_NODATA) & ~holes & (not self.all_heights)
        values = (values * self.data.scales[self.band - 1] + self.data.offsets[self.band - 1]) * self.unit
        odd |= (values < LOWEST_LAND) & (values >= LOWEST_ON_EARTH) & ~holes & (not self.all_heights)
        wild = ~holes & ((values < LOWEST_ON_EARTH) | (values > HIGHEST_ON_EARTH)) & ~odd
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
        """Raise `InputError` for a height, metres, that this share of the pixels looked at has, such as `pixel`.

        Parameters
        ----------
        height, share, pixel
            The height, its share, and the column and row of a pixel that has it.
        why
            What is wrong with the height.
        wild
            Whether its unit may be wrong.
        """
        number = (height / self.unit - self.data.offsets[self.band - 1]) / self.data.scales[self.band - 1]
        single = self.data.dtypes[self.band - 1] == "float32"
        said = str(np.float32(number)).removesuffix(".0") if single else f"{number:.12g}"
        longitude, latitude = self.places(*(np.array([at]) for at in pixel))
        metres = "" if math.isclose(float(said), height, rel_tol=1e-6) else f" ({height:g} m)"
        is_height = Remedy("Raster.nodata", math.nan, "if it is a height")
        raise InputError(
            f"{self.path}: it holds {said}{metres}, {why}, in {100 * share:.3g}% of the pixels looked at, such as at "
            f"latitude {latitude[0]:.6f}, longitude {longitude[0]:.6f}",
            give=[
                Remedy("Raster.nodata", float(said), "if it stands for no data"),
                Remedy("Raster.unit", None, "if heights are in another unit") if wild else is_height,
            ],
        )


def _transformed(transform: Any, first: Floats, second: Floats) -> tuple[Floats, Floats]:
    """Apply a geotransform."""
    a, b, c, d, e, f = transform[:6]
    with np.errstate(invalid="ignore", over="ignore"):  # a place that is not on the map is infinitely far away
        return a * first + b * second + c, d * first + e * second + f


@contextmanager
def open_raster(raster: Raster) -> Iterator[OpenRaster]:
    """Open a raster, or raise `InputError`."""
    require_libraries(str(raster.path), "rasterio", "pyproj")
    import rasterio

    path = Path(raster.path)
    require_file(path)
    _refuse_references(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        warnings.simplefilter("ignore", RuntimeWarning)  # where the number for no data is NaN
        try:
            data = rasterio.open(path)
        except (rasterio.errors.RasterioError, rasterio.errors.CRSError, UnicodeError) as error:
            cause = first_line(error.__cause__ or error)
            raise InputError(
                f"{path}: expected a raster such as a GeoTIFF, found it cut off or something else: {cause}"
            ) from None
        with data:
            yield OpenRaster(raster, data)


def _refuse_references(path: Path) -> None:
    """Refuse a file that names other files, some of them on servers, which GDAL would open."""
    with path.open("rb") as file:
        text = file.read(256).removeprefix(b"\xef\xbb\xbf").lstrip()
    if path.suffix.lower() in (".json", ".geojson"):
        raise InputError(f"{path}: expected a raster of heights, such as a GeoTIFF, found a JSON file")
    if text[:1] in (b"<", b"{") or ".gti" in path.suffixes:
        raise InputError(
            f"{path}: expected a raster such as a GeoTIFF, found a file that only points to others (such as a .vrt); "
            "give those themselves"
        )
