"""Missions flown in a simulator that others maintain: vehicles, what they are told, what came of it."""
