"""Small valid files of every format that skyverse reads, which `fuzz_readers.py` damages."""

import json
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

import skyverse as sky

SQUARE = [[8.10, 47.20], [8.11, 47.20], [8.11, 47.21], [8.10, 47.21], [8.10, 47.20]]
ZONE = {
    "type": "Feature",
    "properties": {"name": "zone", "lower": "0 m agl", "upper": "120 m agl", "kind": "no-fly zone"},
    "geometry": {"type": "Polygon", "coordinates": [SQUARE]},
}
KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>zone</name><Polygon><extrude>1</extrude>
<altitudeMode>relativeToGround</altitudeMode><outerBoundaryIs><LinearRing><coordinates>
8.10,47.20,90 8.11,47.20,90 8.11,47.21,90 8.10,47.20,90
</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>
"""
OSM = """<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6"><node id="1" lat="47.20" lon="8.10"/><node id="2" lat="47.20" lon="8.11"/>
<node id="3" lat="47.21" lon="8.11"/><node id="4" lat="47.21" lon="8.10"/>
<way id="9"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
<tag k="building" v="yes"/><tag k="height" v="12 m"/><tag k="building:levels" v="4"/></way>
<relation id="8"><member type="way" ref="9" role="outer"/><tag k="type" v="multipolygon"/><tag k="building" v="yes"/>
</relation></osm>
"""
CITY = {
    "type": "CityJSON",
    "version": "1.1",
    "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/7415"},
    "transform": {"scale": [0.001, 0.001, 0.001], "translate": [84000.0, 447000.0, 0.0]},
    "vertices": [[x, y, z] for z in (0, 9000) for x, y in ((0, 0), (9000, 0), (9000, 9000), (0, 9000))],
    "CityObjects": {
        "b": {
            "type": "Building",
            "attributes": {"name": "house"},
            "geometry": [
                {
                    "type": "Solid",
                    "lod": "1",
                    "boundaries": [
                        [
                            [[0, 3, 2, 1]],
                            [[4, 5, 6, 7]],
                            [[0, 1, 5, 4]],
                            [[1, 2, 6, 5]],
                            [[2, 3, 7, 6]],
                            [[3, 0, 4, 7]],
                        ]
                    ],
                }
            ],
        },
        "t": {
            "type": "SolitaryVegetationObject",
            "geometry": [
                {
                    "type": "GeometryInstance",
                    "template": 0,
                    "boundaries": [2],
                    "transformationMatrix": [2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1],
                }
            ],
        },
        "m": {"type": "CityFurniture", "geometry": [{"type": "MultiPoint", "lod": "0", "boundaries": [1, 3]}]},
    },
    "geometry-templates": {
        "templates": [{"type": "MultiSurface", "lod": "2", "boundaries": [[[0, 1, 2]], [[0, 1, 3]]]}],
        "vertices-templates": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.2, 0.2, 3.0]],
    },
}
WORLD = {
    "bounds": {"extents": [-2.0, 3.0, -1.0, 4.0, 0.0, 2.5]},
    "blocks": [{"extents": [0.0, 1.0, 0.0, 2.0, 0.0, 2.0], "color": [1, 0, 0]}],
}
COURSE = "boundary 0 -5 0 10 20 6\nblock 0 2 0 10 2.5 1.5 255 0 0\nblock 0 15 1 10 16 3.5 255 0 0\n"
OBJ = "o x\nv 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
3 0 0
0 3 0
0 0 3
3 0 2 1
3 0 1 3
"""
STL = (
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 3 0 0\nvertex 0 3 1\nendloop\nendfacet\nendsolid x\n"
)


def write_seeds(folder: Path) -> dict[str, list[Path]]:
    """Write the seeds that the libraries at hand can write; return the files by format, the first one to be changed."""
    seeds: dict[str, list[Path]] = {}

    def seed(name: str, write: Callable[[Path], object], *beside: str) -> None:
        path = folder / name
        try:
            write(path)
        except (ImportError, sky.InputError) as error:
            print(f"without {name}: {error}")
            return
        seeds[name] = [path, *(folder / other for other in beside)]

    def text(content: str) -> Callable[[Path], object]:
        return lambda path: path.write_text(content, encoding="utf-8")

    fleet = sky.read("table-4.8")
    large = mapped()
    seed("scenario.yaml", lambda path: sky.write(shapes(), path))
    seed("scenario.json", lambda path: sky.write(shapes(), path))
    seed("long.yaml", lambda path: sky.write(fleet.model_copy(update={"obstacles": fleet.obstacles * 10}), path))
    seed("grids.json", lambda path: sky.write(large, path), "grids.json.grids.npz")
    seed("grids.json.grids.npz", lambda path: None, "grids.json")
    seed("mission.json", lambda path: sky.write(sky.plan_mission(sky.read("map1"), sky.AStar()), path))
    seed("course.txt", text(COURSE))
    seed("world.json", text(json.dumps(WORLD)))
    seed("map.3dmap", text("voxel 6 5 4\n0 0 0\n1 2 3\n5 4 3\n"))
    seed("tree.bt", octree)
    seed("tree.ot", octree)
    seed("cloud.las", las)
    seed("cloud.laz", las)
    seed("mesh.obj", text(OBJ))
    seed("mesh.ply", text(PLY))
    seed("mesh.stl", text(STL))
    seed("solid.stl", lambda path: mesh(path))
    seed("solid.ply", lambda path: mesh(path))
    seed("zones.geojson", text(json.dumps({"type": "FeatureCollection", "features": [ZONE]})))
    seed("zones.kml", text(KML))
    seed("houses.osm", text(OSM))
    seed("city.json", text(json.dumps(CITY)))
    seed("zones.gpkg", table)
    seed("zones.fgb", table)
    seed("zones.shp", table, "zones.dbf", "zones.shx", "zones.prj")
    seed("zones.kmz", kmz)
    seed("houses.osm.pbf", pbf)
    seed("aerial.las", aerial)
    seed("aerial.laz", aerial)
    seed("terrain.tif", raster)
    seed("packed.tif", raster)
    seed("terrain.asc", raster, "terrain.prj")
    seed("N46E012.hgt", hgt)
    seed("terrain.bil", raster, "terrain.hdr", "terrain.prj")
    return seeds


def shapes() -> sky.Scenario:
    """Return a scenario with one of each shape, all arrays in the file."""
    occupied = np.zeros((2, 3, 2), dtype=bool)
    occupied[0, 1] = True
    risk = {"risk": 2.0, "kind": "school"}
    hole = ((6.2, 6.2), (6.6, 6.2), (6.4, 6.6))
    return sky.Scenario(
        name="shapes",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 9, 8)),
        obstacles=(
            sky.Box(min=(1, 1, 0), max=(2, 2, 1)),
            sky.Cylinder(centre=(4, 4), radius=0.5, low=0, high=3),
            sky.Prism(vertices=((6, 6), (7, 6), (7, 7), (6, 7)), holes=(hole,), low=0, high=3),
            sky.Voxels(origin=(8, 1, 0), step=(0.5, 0.5, 0.5), occupied=occupied),
        ),
        zones=(sky.Sphere(centre=(3, 3, 3), radius=1, **risk),),
        terrain=sky.Terrain(origin=(-1, -1), step=(4, 4), heights=np.arange(16.0).reshape(4, 4) / 20),
        clearance=0.2,
        lattice=sky.Lattice(step=(1, 1, 1)),
        uavs=(sky.UAV(start=(0.5, 0.5, 4)),),
        targets=(sky.Target(position=(9, 8, 5)),),
        frame=sky.Frame(origin=sky.Origin(latitude=47, longitude=8, altitude=400)),
    )


def mapped() -> sky.Scenario:
    """Return a scenario whose arrays go to a file beside."""
    rng = np.random.default_rng(1)
    voxels = sky.Voxels(origin=(1, 1, 3), step=(0.2, 0.2, 0.2), occupied=rng.random((20, 20, 20)) < 0.1)
    terrain = sky.Terrain(origin=(-1, -1), step=(0.2, 0.2), heights=rng.random((80, 70)))
    return shapes().model_copy(update={"obstacles": (voxels,), "terrain": terrain})


def octree(path: Path) -> None:
    """Write a tree of OctoMap's by hand, binary or not."""
    if path.suffix == ".bt":
        words = [[3] + [0] * 7] * 12 + [[3, 2, 1, 0, 3, 0, 2, 2], [2, 1, 0, 0, 0, 2, 2, 2], [1, 2, 0, 0, 0, 0, 0, 0]]
        body = b"".join(sum(s << 2 * k for k, s in enumerate(word)).to_bytes(2, "little") for word in words)
        nodes, what = 1 + sum(s > 0 for word in words for s in word), "OcTree binary file"
    else:
        masks = [1] * 14 + [7, 0, 0, 0]
        body = b"".join(np.float32(1.5 - k % 2).tobytes() + bytes([mask]) for k, mask in enumerate(masks))
        nodes, what = len(masks), "OcTree file"
    path.write_bytes(f"# Octomap {what}\nid OcTree\nsize {nodes}\nres 0.25\ndata\n".encode() + body)


def las(path: Path) -> None:
    """Write a point cloud."""
    import laspy

    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales = (0.01, 0.01, 0.01)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).uniform(0, 20, (3, 50))
    cloud.write(str(path))


def mesh(path: Path) -> None:
    """Write a mesh, binary."""
    import trimesh

    trimesh.creation.icosphere(subdivisions=1, radius=3.0).export(path)


def table(path: Path) -> None:
    """Write zones as a table of a GIS."""
    import pyogrio
    import shapely

    outline = np.array([shapely.to_wkb(shapely.Polygon(SQUARE))], dtype=object)
    fields = [np.array([10.0]), np.array([90.0]), np.array(["zone"], dtype=object)]
    pyogrio.raw.write(path, outline, fields, ["lower", "upper", "name"], geometry_type="Polygon", crs="EPSG:4326")


def raster(path: Path) -> None:
    """Write heights as a GeoTIFF, or, by its suffix, in another format of GDAL's."""
    import rasterio
    from rasterio.shutil import copy
    from rasterio.transform import from_origin

    drivers = {".bil": "EHdr", ".asc": "AAIGrid"}
    heights = np.random.default_rng(1).random((1, 40, 40)).astype("float32") * 50 + 1500
    kind = {"driver": "GTiff", "width": 40, "height": 40, "count": 1, "dtype": "float32", "nodata": -9999}
    if path.name == "packed.tif":
        kind |= {"compress": "deflate", "predictor": 2, "tiled": True, "blockxsize": 16, "blockysize": 16}
    name = path if path.suffix == ".tif" else path.with_name("terrain.tif")
    with rasterio.open(name, "w", crs="EPSG:32632", transform=from_origin(780000, 5190000, 30, 30), **kind) as file:
        file.write(heights)
    if name != path:
        copy(name, path, driver=drivers[path.suffix])


def hgt(path: Path) -> None:
    """Write a tile of the Shuttle's radar, three seconds a pixel."""
    heights = 1500 + np.random.default_rng(1).integers(0, 50, (1201, 1201))
    path.write_bytes(heights.astype(">i2").tobytes())


def kmz(path: Path) -> None:
    """Write an archive of a KML."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doc.kml", KML)


def aerial(path: Path) -> None:
    """Write a point cloud with coordinates, classes, and points of two kinds."""
    import laspy
    import pyproj

    rng = np.random.default_rng(1)
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = (0.01, 0.01, 0.01), (780000, 5190000, 0)
    header.add_crs(pyproj.CRS(5555))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = rng.uniform((780000, 5190000, 300), (780060, 5190040, 320), (200, 3)).T
    cloud.classification = rng.choice([2, 5, 6, 7], 200).astype(np.uint8)
    cloud.write(str(path))


def pbf(path: Path) -> None:
    """Write a house in OpenStreetMap's binary format."""

    def whole(value: int) -> bytes:
        out = bytearray()
        while value > 127:
            out.append(value & 127 | 128)
            value >>= 7
        return bytes([*out, value])

    def entry(number: int, held: bytes | int) -> bytes:
        if isinstance(held, int):
            return whole(number << 3) + whole(held)
        return whole(number << 3 | 2) + whole(len(held)) + held

    def steps(values: list[int]) -> bytes:
        return b"".join(whole(2 * s if s >= 0 else -2 * s - 1) for s in np.diff([0, *values]).tolist())

    def block(kind: bytes, content: bytes) -> bytes:
        packed = entry(2, len(content)) + entry(3, zlib.compress(content))
        head = entry(1, kind) + entry(3, len(packed))
        return struct.pack(">I", len(head)) + head + packed

    words = entry(1, b"") + entry(1, b"building") + entry(1, b"yes") + entry(1, b"height") + entry(1, b"12")
    corners = np.round(np.array(SQUARE[:4]) * 1e7).astype(int)
    nodes = (
        entry(1, steps([1, 2, 3, 4]))
        + entry(8, steps(corners[:, 1].tolist()))
        + entry(9, steps(corners[:, 0].tolist()))
    )
    way = entry(1, 9) + entry(2, bytes([1, 3])) + entry(3, bytes([2, 4])) + entry(8, steps([1, 2, 3, 4, 1]))
    data = entry(1, words) + entry(2, entry(2, nodes)) + entry(2, entry(3, way))
    head = entry(4, b"OsmSchema-V0.6") + entry(4, b"DenseNodes")
    path.write_bytes(block(b"OSMHeader", head) + block(b"OSMData", data))
