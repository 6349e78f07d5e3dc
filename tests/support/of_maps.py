"""Scenarios of maps, built by keywords."""

import skyverse as sky


def of_maps(name, **options):
    """Return the scenario of a name that `sky.build_scenario` makes with these options."""
    return sky.build_scenario(sky.BuildOptions(name, **options))
