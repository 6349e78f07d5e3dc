"""Compiles what most tests need, in two processes at once: ``python tests/kernels.py``.

Test processes would compile the same kernels at the same time; what stands in the cache they load.
"""

import subprocess
import sys

import skyverse as sky


def any_angle():
    """Taut among boxes, trajectories and conflicts; Taut among other shapes over terrain."""
    sky.Taut().plan(sky.Problem(sky.read("map1")))
    sky.plan_mission(sky.read("table-4.8"), sky.Taut(), rng=1)
    sky.Taut().plan(sky.Problem(sky.read("jacksboro")))


def lattice():
    """A* and the hybrids; MVO, whose mission needs by then what the other process has compiled."""
    stop = sky.MaxIterations(2)
    fleet = sky.read("table-4.8")
    sky.HybridMVO().plan(sky.Problem(fleet), stop=stop, rng=1)
    sky.HybridMVO(legs="straight").plan(sky.Problem(sky.random_threats()), stop=stop, rng=1)
    sky.plan_mission(fleet, sky.MVO(), stop=stop, rng=1)


PARTS = {part.__name__: part for part in (any_angle, lattice)}

if __name__ == "__main__":
    if sys.argv[1:]:
        PARTS[sys.argv[1]]()
    else:
        running = [subprocess.Popen([sys.executable, __file__, name]) for name in PARTS]
        sys.exit(max(process.wait() for process in running))
