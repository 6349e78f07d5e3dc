"""Glowworm Swarm Optimization (Krishnanand, Ghose 2009) for lattice paths."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import kernel
from skyverse.planners.base import Run, require, require_between
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.moves import Desk, Paths, Task, adopt, exhausted, graft, reroute
from skyverse.space.lattice import position

SAMPLES = 16
"""At so many shares of their nodes the distance between two paths is taken."""


class Swarm(NamedTuple):
    """What glowworms remember: luciferin (n,), decision range (n,) metres, and their paths' samples (n, SAMPLES, 3)."""

    luciferin: Floats
    reach: Floats
    places: Floats


@dataclass(frozen=True, kw_only=True)
class GSO(LatticeSearch):
    """Glowworm Swarm Optimization: glowworms are paths, which move towards brighter ones in their decision range.

    The default is the algorithm *as described* in the original paper, on paths, which leave open what moving is:

    - **brightness** J is the cost, negated: cheaper is brighter;
    - **distance** between two paths is the mean distance of the places that they reach after equal shares of their
      nodes, in metres;
    - **moving** towards a brighter glowworm takes over a stretch of its path, reached and left by the generator,
      whether that makes the glowworm brighter or not; glowworms move one after another.

    It departs from the paper in what a glowworm does that sees no brighter one: only the brightest of all stays; the
    others explore, by the thesis's Case 2 (from a random point of the path through a random free point to the goal),
    and so do all while none has reached the goal.

    With ``as_run=True`` it is what was run in the published experiments: brightness was the cost itself, and the
    distance that between the paths' ends, which is 0 between complete paths; so nobody had neighbours, and every
    glowworm took Case 2 every time.

    Attributes
    ----------
    glowworms
        The population.
    as_run
        Whether to run what was run, not what is described.
    luciferin
        At first, for all.
    decay, gain
        rho and gamma of l = (1 - rho) l + gamma J.
    reach, reach_max
        The decision range at first, and at most, metres.
    neighbours
        n_t: how many are wanted within the decision range.
    beta
        How fast the range follows that wish, metres a neighbour.

    References
    ----------
    K. N. Krishnanand, D. Ghose, "Glowworm swarm optimization for simultaneous capture of multiple local optima of
    multimodal functions", Swarm Intelligence 3 (2009).
    """

    glowworms: int = 25
    as_run: bool = False
    luciferin: float = 25.0
    decay: float = 0.4
    gain: float = 0.6
    reach: float = 5.0
    reach_max: float = 50.2
    neighbours: int = 20
    beta: float = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, "glowworms", 2)
        require(self, "neighbours", 1)
        if not isinstance(self.as_run, bool):
            raise ValueError(f"GSO's as_run is True or False, not {self.as_run!r}")
        require_between(self, "luciferin", -1e9, 1e9)
        require_between(self, "decay", 0, 1)
        require_between(self, "gain", 1e-9, 1e9)
        require_between(self, "reach_max", 0, 1e9)
        require_between(self, "reach", 0, self.reach_max)
        require_between(self, "beta", 0, 1e9)

    @property
    def population(self) -> int:
        """How many glowworms there are."""
        return self.glowworms

    def begin(self, run: Run) -> object:
        """Place the glowworms, equally bright."""
        super().begin(run)
        n = self.glowworms
        return Swarm(np.full(n, float(self.luciferin)), np.full(n, float(self.reach)), np.empty((n, SAMPLES, 3)))

    def step(self, run: Run, spent: float) -> None:
        """Do one iteration: luciferin, movement, decision range."""
        if self.as_run:
            _as_run(run.task, run.desk, run.paths, run.best, run.rng, self.repair_threshold, self.retries)
        else:
            swarm: Swarm = run.memory
            _glow(run.task, run.paths, swarm, self.decay, self.gain)
            _move(
                run.task,
                run.desk,
                run.paths,
                run.best,
                run.rng,
                swarm,
                self.reach_max,
                float(self.neighbours),
                self.beta,
                self.repair_threshold,
                self.retries,
            )


@kernel
def _glow(task: Task, x: Paths, swarm: Swarm, rho: float, gamma: float) -> None:
    """Update luciferin, l = (1 - rho) l + gamma J, and where the paths lead."""
    for i in range(len(x.length)):
        swarm.luciferin[i] = (1.0 - rho) * swarm.luciferin[i] - gamma * x.cost[i]
        for s in range(SAMPLES):
            p = position(task.grid, x.nodes[i, (s + 1) * (x.length[i] - 1) // SAMPLES])
            for axis in range(3):
                swarm.places[i, s, axis] = p[axis]


@kernel
def _move(
    task: Task,
    desk: Desk,
    x: Paths,
    best: Paths,
    rng: np.random.Generator,
    swarm: Swarm,
    r_s: float,
    n_t: float,
    beta: float,
    threshold: int,
    retries: int,
) -> None:
    n = len(x.length)
    luciferin = swarm.luciferin
    brighter = np.empty(n)
    leader = int(np.argmax(luciferin))
    for i in range(n):
        if exhausted(desk):
            return
        seen = 0
        total = 0.0
        worthwhile = best.nodes[0, best.length[0] - 1] == task.goal
        for j in range(n):
            brighter[j] = max(0.0, luciferin[j] - luciferin[i])
            if not worthwhile or brighter[j] == 0.0 or _distance(swarm, i, j) >= swarm.reach[i]:
                brighter[j] = 0.0
            else:
                seen += 1
                total += brighter[j]
        if seen:
            spin = rng.random() * total  # p_ij = (l_j - l_i) / sum over N_i
            chosen = i
            for j in range(n):
                if spin >= 0.0 and brighter[j] > 0.0:
                    chosen = j
                    spin -= brighter[j]
            adopt(task, desk, x, i, best, graft(task, desk, rng, x, i, chosen, threshold))
        elif i != leader:
            adopt(task, desk, x, i, best, reroute(task, desk, rng, x, i, threshold, retries))
        swarm.reach[i] = min(r_s, max(0.0, swarm.reach[i] + beta * (n_t - seen)))


@kernel
def _distance(swarm: Swarm, i: int, j: int) -> float:
    total = 0.0
    for s in range(SAMPLES):
        a, b = swarm.places[i, s], swarm.places[j, s]
        total += math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
    return total / SAMPLES


@kernel
def _as_run(
    task: Task, desk: Desk, x: Paths, best: Paths, rng: np.random.Generator, threshold: int, retries: int
) -> None:
    for i in range(len(x.length)):
        if exhausted(desk):
            return
        adopt(task, desk, x, i, best, reroute(task, desk, rng, x, i, threshold, retries))
