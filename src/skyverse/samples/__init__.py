"""Seeded random scenarios to try planners on."""
