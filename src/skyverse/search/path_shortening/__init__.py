"""Every way to shorten a free path by lines of sight.

`shortcut` leaves waypoints out, `shorten` moves bends by exact bisection, `merge_bends` makes one bend of two, and
`shorten_by_steps` moves bends by steps of the lattice's size.
"""
