"""
A scenario of your own
======================

Build a scenario in code, keep it as YAML, plan it with turns priced, check it, and write every file there is.
"""

import tempfile
from pathlib import Path

import skyverse as sky

# %%
# A courtyard, a wall across it with a window, and a hedge. Every field is validated; metres and seconds throughout.

scenario = sky.Scenario(
    name="courtyard",
    description="Two UAVs and a wall with a window",
    bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 4)),
    obstacles=(
        sky.Box(min=(0, 4.5, 0), max=(10, 5, 1.5)),
        sky.Box(min=(0, 4.5, 2.5), max=(10, 5, 4)),
        sky.Box(min=(0, 4.5, 1.5), max=(4, 5, 2.5)),
        sky.Box(min=(6, 4.5, 1.5), max=(10, 5, 2.5)),
        sky.Box(min=(3, 7, 0), max=(7, 7.5, 2)),
    ),
    clearance=0.25,
    lattice=sky.Lattice(step=(0.1, 0.1, 0.1)),
    objective=sky.Objective(fuel=1, divergence=0.3, end=100, unit="metres"),
    uavs=(sky.UAV(name="scout", start=(2, 1, 1), max_speed=3), sky.UAV(name="carrier", start=(8, 1, 1))),
    targets=(sky.Target(name="gate", position=(8, 9, 1)), sky.Target(name="roof", position=(2, 9, 3))),
)

# %%
# Is a point safe? Obstacles count with their clearance.

world = sky.World(scenario)
print(world.free([[5, 4.75, 2], [5, 4.75, 1.6]]))
print(world.why_unsafe([5, 4.75, 1.6]))

# %%
# As a file. Reading it back gives an equal scenario; a misspelt key is refused with one sentence.

folder = Path(tempfile.mkdtemp())
sky.write(scenario, folder / "courtyard.yaml")
assert sky.read(folder / "courtyard.yaml") == scenario

misspelt = folder / "misspelt.yaml"
misspelt.write_text((folder / "courtyard.yaml").read_text().replace("clearance:", "clearence:"))
try:
    sky.read(misspelt)
except sky.InputError as error:
    print(str(error).replace(str(folder), "..."))

# %%
# Plan with MVO: the gap to the exact optimum says how good the paths are.

mission = sky.plan_mission(scenario, sky.MVO(), stop=sky.MaxIterations(40), rng=1)
for uav, target, result in zip(scenario.uavs, mission.assignment, mission.results, strict=True):
    shares = ", ".join(f"{term} {share:.1f}" for term, share in result.terms.items())
    print(f"{uav.name} to {scenario.targets[target].name}: {result.cost:.1f} ({shares}), gap {result.gap:.1%}")

# %%
# Let the referee judge it, and write the files. They hold all but what the referee proved, which `certify` proves anew.

print(sky.check(scenario, mission))
sky.write(mission, folder / "courtyard.json")
sky.write(mission, folder / "courtyard.waypoints.csv")
sky.write(mission, folder / "courtyard.csv", rate=10)
sky.write_html(mission, folder / "courtyard.html")
again = sky.read_mission(folder / "courtyard.json")
assert again.results == mission.results
assert again.trajectories == mission.trajectories
assert sky.certify(scenario, again).trajectories == mission.certificates
print(sorted(path.name for path in folder.iterdir()))

# %%
# A trajectory is a function of time. This is the carrier's, with its limits.

sky.plot(mission.trajectories[1], scenario.uavs[1])
