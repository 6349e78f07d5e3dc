"""The one error that bad input ends in."""


class InputError(ValueError):
    """What the user gave cannot be used; the message names file and field, what was expected and found."""
