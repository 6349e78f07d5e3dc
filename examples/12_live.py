"""
Steered from another program
============================

``skyverse live`` reads what is observed, a line of JSON for each instant, and answers each line with the motion to fly
from now on. Whatever can start a program or open a socket can steer a mission so; this script stands for it.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import skyverse as sky

folder = tempfile.TemporaryDirectory()
file = str(Path(folder.name, "map3.json"))
sky.write(sky.plan_mission(sky.read("map3"), sky.Taut()), file)

live = subprocess.Popen(
    [sys.executable, "-m", "skyverse", "live", file, "--setpoints", "10"],
    stdin=subprocess.PIPE,
    stdout=subprocess.PIPE,
    stderr=subprocess.DEVNULL,
    text=True,
)
hello = json.loads(live.stdout.readline())
print(f"{hello['format']}: {hello['uavs'][0]['name']} flies to {hello['uavs'][0]['target']}")


def ask(**observation):
    """Send what was observed, and return what is answered."""
    print(json.dumps(observation), file=live.stdin, flush=True)
    return json.loads(live.stdout.readline())


# %%
# A ball that comes towards the UAV is seen ten times a second. Each answer has the motion as polynomials, and since
# setpoints were asked for, as rows of position, velocity and acceleration that need no evaluation.

ball = {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.3}
t, arrival = 0.0, None
while arrival is None or t < arrival:
    seen = {"name": "ball", "shape": ball, "position": [1.0, 12.0 - t, 2.0], "top_speed": 1.2, "max_acceleration": 0.3}
    (uav,) = ask(t=t, movers=[seen])["uavs"]
    arrival = uav["arrival"]
    t = round(t + 0.1, 1)
print(uav["sentence"], f"It arrives after {arrival:.1f} s.")
print({name: rows[0] for name, rows in uav["setpoints"].items() if rows})

# %%
# What cannot be taken in is answered by a sentence, and changes nothing.

print(ask(t=t, movers=[{**seen, "position": [1.0, 12.0, float("nan")]}])["error"]["message"])
print(ask(t=0.0)["error"]["message"])

live.communicate()
folder.cleanup()
