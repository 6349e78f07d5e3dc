"""Small missions in the forms in which their makers publish the formats, written by hand."""

import io
import json
import zipfile

NAN = None


def item(command, *numbers, frame=3, number=1, **more):
    return {
        "autoContinue": True,
        "command": command,
        "doJumpId": number,
        "frame": frame,
        "params": list(numbers),
        "type": "SimpleItem",
        **more,
    }


def plan(items, firmware=12, **more):
    mission = {
        "cruiseSpeed": 15,
        "firmwareType": firmware,
        "globalPlanAltitudeMode": 1,
        "hoverSpeed": 5,
        "items": items,
        "plannedHomePosition": [47.0, 8.0, 400.0],
        "vehicleType": 2,
        "version": 2,
    }
    parts = {
        "fileType": "Plan",
        "geoFence": {"circles": [], "polygons": [], "version": 2},
        "groundStation": "QGroundControl",
        "mission": mission,
        "rallyPoints": {"points": [], "version": 2},
        "version": 1,
    }
    return json.dumps({**parts, **more}, indent=4)


def survey(items):
    """A survey as QGroundControl stores it, with the items that it stands for."""
    stored = {"Items": items, "CameraShots": 4, "version": 1}
    return {"type": "ComplexItem", "complexItemType": "survey", "version": 5, "TransectStyleComplexItem": stored}


FLIGHT = [
    item(22, 0, 0, 0, NAN, 47.0, 8.0, 30, number=1, Altitude=30, AltitudeMode=1, AMSLAltAboveTerrain=None),
    item(178, 1, 6.5, -1, 0, 0, 0, 0, frame=2, number=2),
    survey(
        [
            item(16, 0, 0, 0, NAN, 47.001, 8.0, 30, number=3),
            item(206, 12.5, 0, 1, 0, 0, 0, 0, frame=2, number=4),
            item(16, 2.5, 3, 0, 90, 47.001, 8.002, 30, number=5),
        ]
    ),
    item(177, 3, 2, 0, 0, 0, 0, 0, frame=2, number=6),
    item(31010, 1, 2, 3, 4, 5, 6, 7, frame=2, number=7),
    item(16, 0, 0, 0, NAN, 47.003, 8.003, 460, frame=0, number=8, Altitude=460, AltitudeMode=2),
    item(20, 0, 0, 0, 0, 0, 0, 0, frame=2, number=9),
]
"""Take off, fly a survey thrice, do something unknown, rise, return."""

WPL = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t47.0\t8.0\t400.0\t1
1\t0\t3\t22\t0\t0\t0\t0\t0\t0\t30\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.001\t8.0\t30.000000\t1
3\t0\t3\t18\t2\t0\t-25\t0\t47.001\t8.002\t30.000000\t1
4\t0\t2\t177\t2\t1\t0\t0\t0\t0\t0\t1
5\t0\t10\t16\t1.50\t0\t0\t0\t47.003\t8.003\t50.000000\t1
6\t0\t3\t21\t0\t0\t0\t0\t0\t0\t0\t1
"""


def dji_document(config, folder, version="1.0.6"):
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:wpml="http://www.dji.com/wpmz/{version}">\n'
        f"  <Document>\n    <!-- kept -->\n{config}{folder}  </Document>\n</kml>\n"
    )


def leaves(indent=4, **texts):
    return "".join(f"{' ' * indent}<wpml:{tag}>{text}</wpml:{tag}>\n" for tag, text in texts.items())


def dji_config(finish="goHome", **more):
    start = {"flyToWaylineMode": "safely", "finishAction": finish, "exitOnRCLost": "goContinue"}
    rest = {"takeOffSecurityHeight": 20, **more, "globalTransitionalSpeed": 9}
    drone = "    <wpml:droneInfo><wpml:droneEnumValue>77</wpml:droneEnumValue></wpml:droneInfo>\n"
    return f"    <wpml:missionConfig>\n{leaves(**start, **rest)}{drone}    </wpml:missionConfig>\n"


def dji_mark(k, latitude, longitude, inner):
    point = f"<Point>\n        <coordinates>{longitude},{latitude}</coordinates>\n      </Point>\n"
    return f"    <Placemark>\n      {point}{leaves(6, index=k)}{inner}    </Placemark>\n"


def turn(mode, damping=0, straight=1):
    inner = leaves(8, waypointTurnMode=mode, waypointTurnDampingDist=damping)
    return f"      <wpml:waypointTurnParam>\n{inner}      </wpml:waypointTurnParam>\n" + leaves(
        6, useStraightLine=straight
    )


def group(first, last, trigger, actions, param=None):
    """A group of actions, each given by its name and its parameters."""
    when = leaves(8, actionTriggerType=trigger) + ("" if param is None else leaves(8, actionTriggerParam=param))
    made = "".join(
        f"        <wpml:action>{leaves(0, actionId=k, actionActuatorFunc=name)}"
        f"<wpml:actionActuatorFuncParam>{leaves(0, **params)}</wpml:actionActuatorFuncParam></wpml:action>\n"
        for k, (name, params) in enumerate(actions)
    )
    index = leaves(8, actionGroupId=first, actionGroupStartIndex=first, actionGroupEndIndex=last)
    return (
        f"      <wpml:actionGroup>\n{index}        <wpml:actionGroupMode>sequence</wpml:actionGroupMode>\n"
        f"        <wpml:actionTrigger>\n{when}        </wpml:actionTrigger>\n{made}      </wpml:actionGroup>\n"
    )


STOP, EARLY, PASS = (
    "toPointAndStopWithDiscontinuityCurvature",
    "coordinateTurn",
    "toPointAndPassWithContinuityCurvature",
)
PLACES = [(47.001, 8.0), (47.001, 8.002), (47.002, 8.002), (47.003, 8.003)]
HEIGHTS = [50.0, 52.5, 60.0, 55.0]
GROUPS = {
    1: group(1, 1, "reachPoint", [("hover", {"hoverTime": 4}), ("takePhoto", {"payloadPositionIndex": 0})]),
    2: group(2, 3, "multipleDistance", [("takePhoto", {"payloadPositionIndex": 0})], param=15)
    + group(2, 2, "reachPoint", [("rotateYaw", {"aircraftHeading": -90}), ("megaphone", {})]),
}
TURNS = [turn(STOP), turn(EARLY, 5), turn(PASS, 0.5, 1), turn(PASS, 0.5, 0)]


def waylines(mode="relativeToStartPoint", raised=0.0, **config):
    marks = "".join(
        dji_mark(
            k, *place, leaves(6, executeHeight=height + raised, waypointSpeed=4 + k) + TURNS[k] + GROUPS.get(k, "")
        )
        for k, (place, height) in enumerate(zip(PLACES, HEIGHTS, strict=True))
    )
    head = leaves(templateId=0, executeHeightMode=mode, waylineId=0, autoFlightSpeed=5)
    return dji_document(dji_config(**config), f"    <Folder>\n{head}{marks}    </Folder>\n")


def template(mode="relativeToStartPoint", geoid=0.0, kind="waypoint", **config):
    marks = "".join(
        dji_mark(
            k,
            *place,
            leaves(
                6, ellipsoidHeight=height + geoid, height=height, useGlobalHeight=0, useGlobalSpeed=0, waypointSpeed=4
            )
            + leaves(6, useGlobalTurnParam=1)
            + GROUPS.get(k, ""),
        )
        for k, (place, height) in enumerate(zip(PLACES, HEIGHTS, strict=True))
    )
    system = leaves(6, coordinateMode="WGS84", heightMode=mode)
    head = leaves(templateType=kind, templateId=0, autoFlightSpeed=5, globalHeight=40, globalWaypointTurnMode=STOP)
    system = f"    <wpml:waylineCoordinateSysParam>\n{system}    </wpml:waylineCoordinateSysParam>\n"
    more = {"takeOffRefPoint": f"47.0,8.0,{400 + geoid}", **config}
    return dji_document(dji_config(**more), f"    <Folder>\n{head}{system}{marks}    </Folder>\n")


def kmz(**files):
    """An archive of files; a double underscore in a name stands for a slash, a single one for a dot."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "/").replace("_", "."), text)
    return made.getvalue()


def dji(**how):
    return kmz(wpmz__template_kml=template(**how), wpmz__waylines_wpml=waylines(), wpmz__res__note_txt=b"\x00kept")


_ACTIONS = [f"action{what}{k}" for k in range(1, 16) for what in ("type", "param")]
LITCHI_COLUMNS = [
    *("latitude", "longitude", "altitude(m)", "heading(deg)", "curvesize(m)", "rotationdir", "gimbalmode"),
    *("gimbalpitchangle", *_ACTIONS, "altitudemode", "speed(m/s)", "poi_latitude", "poi_longitude"),
    *("poi_altitude(m)", "poi_altitudemode", "photo_timeinterval", "photo_distinterval"),
]


def litchi_row(latitude, longitude, altitude, actions=(), **more):
    cells = dict.fromkeys(LITCHI_COLUMNS, 0) | {name: -1 for name in _ACTIONS if "type" in name}
    cells |= {"photo_timeinterval": -1.0, "photo_distinterval": -1.0, "speed(m/s)": 5.5, "altitudemode": 1}
    cells |= {"latitude": latitude, "longitude": longitude, "altitude(m)": altitude}
    for k, (kind, param) in enumerate(actions, 1):
        cells |= {f"actiontype{k}": kind, f"actionparam{k}": param}
    return cells | more


LITCHI_ROWS = [
    litchi_row(47.001, 8.0, 30.0, [(0, 2500), (1, 0)], **{"heading(deg)": 90.0, "curvesize(m)": 4.5}),
    litchi_row(47.001, 8.002, 31.5, [(4, 180), (5, -60)], gimbalmode=2, gimbalpitchangle=-45, photo_distinterval=20.0),
    litchi_row(47.002, 8.002, 32.0, poi_latitude=47.005, poi_longitude=8.005, altitudemode=0, **{"speed(m/s)": 0}),
]


def litchi(rows=LITCHI_ROWS, columns=LITCHI_COLUMNS, end="\r\n"):
    return end.join([",".join(columns), *(",".join(str(row[name]) for name in LITCHI_COLUMNS) for row in rows), ""])


def kml(*marks):
    inner = "".join(marks)
    return f'<?xml version="1.0"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{inner}</Document></kml>'


def kml_mark(name, shape, coordinates, mode=None):
    inner = "" if mode is None else f"<altitudeMode>{mode}</altitudeMode>"
    inner = f"<{shape}>{inner}<coordinates>{coordinates}</coordinates></{shape}>"
    return f"<Placemark><name>{name}</name>{inner}</Placemark>\n"


KML_LINE = kml(
    kml_mark("Route", "LineString", "\n  8.0,47.001,30\n  8.002,47.001,31.5\n  8.002,47.002,32\n", "absolute")
)
KML_POINTS = kml(*(kml_mark(f"P{k}", "Point", f"{8 + k / 1000},47.001,{30 + k}", "relativeToGround") for k in range(3)))
GPX = """<?xml version="1.0" encoding="UTF-8"?>
<gpx version="1.1" creator="somebody" xmlns="http://www.topografix.com/GPX/1/1">
  <rte>
    <name>Route</name>
    <rtept lat="47.001" lon="8.0"><ele>430</ele></rtept>
    <rtept lat="47.001" lon="8.002"><ele>431.5</ele><name>gate</name></rtept>
    <rtept lat="47.002" lon="8.002"><ele>432</ele></rtept>
  </rte>
</gpx>
"""
EVERY_FORMAT = {
    "m.plan": (plan(FLIGHT), {}),
    "m.waypoints": (WPL, {}),
    "m.txt": (WPL.replace("\n", "\r\n"), {}),
    "m.wpml.kmz": (dji(), {}),
    "google.kmz": (kmz(doc_kml=KML_LINE), {}),
    "m.csv": (litchi(), {}),
    "line.kml": (KML_LINE, {}),
    "points.kml": (KML_POINTS, {}),
    "m.gpx": (GPX, {"altitude": "amsl"}),
}


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path
