"""The planners: frozen parameters with one verb, ``plan(problem, *, stop, rng, on_iteration) -> Result``."""
