"""The codes with which the program ends, besides 0 for all is well."""

FOUND_WRONG = 1
"""What was checked is wrong or could not be decided, a UAV has no path, or a run of a study could not be done.

A script may rely on 0: all that it asked for is proven.
"""
BAD_INPUT = 2
"""What the user gave cannot be used."""
NO_VERDICT = 3
"""A mission was flown by another vehicle than the planned one, which says nothing of it."""
INTERRUPTED = 130
"""The user pressed Ctrl-C."""
OUTPUT_CLOSED = 141
"""Whoever read the output has closed it, as ``head`` does; that is how shells count a program that a pipe ended."""
