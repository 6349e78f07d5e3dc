"""Fleets that stay apart: conflicts between timed trajectories, found exactly and resolved."""
