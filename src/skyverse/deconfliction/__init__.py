"""Deconfliction of fleets: conflicts between timed trajectories are found in continuous time and resolved."""
