"""Glowworm Swarm Optimization (Krishnanand, Ghose 2009) for lattice paths."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from skyverse._typing import Floats
from skyverse.errors import require_flag, require_number, require_whole
from skyverse.numerics.kernel import by_reference, kernel
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.metaheuristic import LatticeRun
from skyverse.planners.moves import LatticeTask, Paths, Workspace, adopt, exhausted
from skyverse.planners.path_changes import graft, reroute
from skyverse.space.lattice import position

PATH_SAMPLES = 16
"""The number of nodes of each path between which the distance of two paths is measured."""


@by_reference
class Swarm(NamedTuple):
    """What n glowworms remember from step to step.

    Attributes
    ----------
    luciferin
        (n,) the attraction of each.
    reach
        (n,) metres: the decision range of each.
    places
        (n, PATH_SAMPLES, 3) metres: the positions of each path after equal shares of its nodes.
    """

    luciferin: Floats
    reach: Floats
    places: Floats


@dataclass(frozen=True, kw_only=True)
class GSO(LatticeSearch):
    """Glowworm Swarm Optimization: glowworms are paths that move towards brighter ones in their decision range.

    The default is the algorithm *as described* in the original paper. On paths it has to be defined what moving is:

    - **brightness** J is the negated cost, so that a cheaper path is brighter;
    - the **distance** between two paths is the mean distance, in metres, between the nodes that they reach after equal
      shares of their nodes;
    - **moving** towards a brighter glowworm takes over a stretch of its path, which the generator joins to the rest of
      the path, whether that makes the glowworm brighter or not. Glowworms move one after another.

    It departs from the paper where a glowworm sees no brighter one. Only the brightest of all stays as it is. The
    others explore by the thesis's Case 2: the generator continues from a random node of the path through a random free
    node to the goal. As long as no path reaches the goal, all glowworms explore.

    With ``as_run=True`` the planner does what was run in the published experiments: brightness is the cost itself, and
    the distance is that between the paths' ends, which is 0 between complete paths. So no glowworm has neighbours, and
    each one takes Case 2 every time.

    Attributes
    ----------
    glowworms
        The number of glowworms.
    as_run
        Whether to do what was run, instead of what is described.
    luciferin
        The luciferin of every glowworm at the start.
    decay, gain
        rho and gamma of l = (1 - rho) l + gamma J.
    reach, reach_max
        The decision range at the start, and the largest, metres.
    neighbours
        n_t: how many brighter glowworms a decision range should contain.
    beta
        How much the range changes for each neighbour too few or too many, metres.

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
        require_whole(self.glowworms, "glowworms", 2)
        require_whole(self.neighbours, "neighbours", 1)
        require_flag(self.as_run, "as_run")
        require_number(self.luciferin, "luciferin", least=-1e9, most=1e9)
        require_number(self.decay, "decay", least=0, most=1)
        require_number(self.gain, "gain", least=1e-9, most=1e9)
        require_number(self.reach_max, "reach_max", least=0, most=1e9)
        require_number(self.reach, "reach", least=0, most=self.reach_max)
        require_number(self.beta, "beta", least=0, most=1e9)

    @property
    def population(self) -> int:
        """How many glowworms there are."""
        return self.glowworms

    def begin(self, run: LatticeRun) -> Swarm:
        """Generate the first population, and give all glowworms the same luciferin."""
        super().begin(run)
        n = self.glowworms
        return Swarm(np.full(n, float(self.luciferin)), np.full(n, float(self.reach)), np.empty((n, PATH_SAMPLES, 3)))

    def step(self, run: LatticeRun, spent: float) -> None:
        """Do one iteration: luciferin, movement, decision range."""
        task, workspace, paths, best, rng, swarm = run.task, run.workspace, run.paths, run.best, run.rng, run.memory
        if self.as_run:
            _as_run(task, workspace, paths, best, rng)
        else:
            assert isinstance(swarm, Swarm)
            _glow(task, paths, swarm, self.decay, self.gain)
            rule = float(self.reach_max), float(self.neighbours), float(self.beta)
            _move(task, workspace, paths, best, rng, swarm, rule)


@kernel
def _glow(task: LatticeTask, x: Paths, swarm: Swarm, rho: float, gamma: float) -> None:
    """Update the luciferin, l = (1 - rho) l + gamma J, and the sampled positions of all paths."""
    for i in range(len(x.length)):
        swarm.luciferin[i] = (1.0 - rho) * swarm.luciferin[i] - gamma * x.cost[i]
        for s in range(PATH_SAMPLES):
            p = position(task.grid, x.nodes[i, (s + 1) * (x.length[i] - 1) // PATH_SAMPLES])
            for axis in range(3):
                swarm.places[i, s, axis] = p[axis]


@kernel
def _move(
    task: LatticeTask,
    workspace: Workspace,
    x: Paths,
    best: Paths,
    rng: Generator,
    swarm: Swarm,
    rule: tuple[float, float, float],
) -> None:
    r_s, n_t, beta = rule  # of the decision range: the largest, how many neighbours it should have, its change for each
    n = len(x.length)
    luciferin = swarm.luciferin
    brighter = np.empty(n)
    leader = int(np.argmax(luciferin))
    for i in range(n):
        if exhausted(workspace):
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
            adopt(task, workspace, x, i, best, graft(task, workspace, rng, x, i, chosen))
        elif i != leader:
            adopt(task, workspace, x, i, best, reroute(task, workspace, rng, x, i))
        swarm.reach[i] = min(r_s, max(0.0, swarm.reach[i] + beta * (n_t - seen)))


@kernel
def _distance(swarm: Swarm, i: int, j: int) -> float:
    """Return the mean distance between the sampled positions of two paths, metres."""
    total = 0.0
    for s in range(PATH_SAMPLES):
        a, b = swarm.places[i, s], swarm.places[j, s]
        total += math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
    return total / PATH_SAMPLES


@kernel
def _as_run(task: LatticeTask, workspace: Workspace, x: Paths, best: Paths, rng: Generator) -> None:
    for i in range(len(x.length)):
        if exhausted(workspace):
            return
        adopt(task, workspace, x, i, best, reroute(task, workspace, rng, x, i))
