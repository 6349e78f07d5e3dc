"""Where a UAV may be: the compiled world, and the lattice over it."""
