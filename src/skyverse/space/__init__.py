"""Where a UAV may be: a scenario's space compiled to arrays, and the lattice over it."""
