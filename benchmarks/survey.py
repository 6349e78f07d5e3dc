"""Surveys beside truth: ``python benchmarks/survey.py PART ...``, each part with what it takes.

- ``ac_eth FOLDER COSTS``, ``ac_agarwal FOLDER COSTS``: strips of AC maps beside published costs. The folder is AC300 of
  https://github.com/UNCCharlotte-CS-Robotics/AreaCoverage-dataset, the costs a table of the published ones.
- ``bound FOLDER COSTS``: gaps to our lower bounds on the maps with 15 holes.
- ``coverage [CASES] [FIRST]``: what the certificate claims of random ground beside rays that share no code with it.
- ``terrain [RUNS] [DEM.tif]``: strips over random alps, and over the steepest square of an elevation model in metres:
  ground sample distance, overlap, photos, bends.
- ``scale [SIDE ...]``: seconds by phase and memory of whole surveys over a ground grid of 1 m, with zones and UAVs.
- ``sorties FOLDER COSTS [EVERY]``: AC maps in sorties of 1,200 s beside one route.
- ``fleet FOLDER COSTS VM25 CTU [EVERY]``: three UAVs, the longest flight beside its bound.
- ``zones_planar [RUNS]``: random areas with up to 20 zones, judged by shapely.
- ``peers PYTHON ... [FOLDER]``: strips beside those of other planners at equal coverage; the Pythons are of virtual
  environments that have them, the folder has areas of others.
- ``triggers [SURVEYS] [FIRST]``: photos of random planned surveys, replayed from their files by autopilots' rules.
- ``readers FOLDER [FIRST]``: files of planned surveys, read by others' readers; a folder of plans of QGroundControl.
- ``reflight [RUNS]``: reflights of random gaps beside the linear programme of strips.
- ``structure [MESH.stl] [SECONDS]``: viewpoints beside the linear programme of set cover, their tour beside PyVRP's.
"""

import importlib
import sys
from pathlib import Path

from machine import describe

PARTS = {
    "ac_eth": "survey_ac",
    "ac_agarwal": "survey_ac",
    "bound": "survey_ac",
    "coverage": "survey_coverage",
    "terrain": "survey_terrain",
    "scale": "survey_scale",
    "sorties": "survey_sorties",
    "fleet": "survey_fleet",
    "zones_planar": "survey_zones",
    "peers": "survey_peers",
    "triggers": "survey_triggers",
    "readers": "survey_readers",
    "reflight": "survey_reflight",
    "structure": "survey_structure",
}


def main() -> None:
    if len(sys.argv) < 2 or sys.argv[1] not in PARTS:
        sys.exit(__doc__)
    part = getattr(importlib.import_module(PARTS[sys.argv[1]]), sys.argv[1])
    given = [int(text) if text.isdigit() else Path(text) for text in sys.argv[2:]]
    print(describe())
    part(*given)


if __name__ == "__main__":
    main()
