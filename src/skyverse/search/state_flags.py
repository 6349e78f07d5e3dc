"""How a lattice search marks its states, in a byte for each; the other bits say from where a state was reached."""

SEEN = 64
CLOSED = 128

ORIGIN = 31
"""In place of a move or an axis: the search began here."""
