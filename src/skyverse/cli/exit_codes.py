"""The codes with which the program ends, besides 0 for all is well."""

FOUND_WRONG = 1
"""What was checked is wrong, a UAV has no path, or a run of a study could not be done."""
BAD_INPUT = 2
"""What the user gave cannot be used."""
INTERRUPTED = 130
"""The user pressed Ctrl-C."""
