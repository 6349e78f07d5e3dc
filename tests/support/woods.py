"""Random woods: fields of trunks with a UAV that has to cross them."""

import numpy as np

import skyverse as sky


def woods(seed, **more):
    """A field of trunks, a UAV and its target."""
    rng = np.random.default_rng(seed)
    start, end = rng.uniform((5, 20, 5), (20, 180, 20)), rng.uniform((180, 20, 5), (195, 180, 20))
    trunks = [(*rng.uniform(0, 200, 2), rng.uniform(0.5, 5)) for _ in range(60)]
    trunks = [t for t in trunks if all(np.hypot(t[0] - e[0], t[1] - e[1]) > t[2] + 4 for e in (start, end))]
    return sky.Scenario(
        name="woods",
        bounds=sky.Bounds(min=(0, 0, 0), max=(200, 200, 30)),
        obstacles=[sky.Cylinder(centre=(x, y), radius=r, low=0, high=30) for x, y, r in trunks],
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=start, max_speed=float(rng.choice([5, 10, 15])))],
        targets=[sky.Target(position=end)],
        **more,
    )
