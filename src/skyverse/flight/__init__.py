"""Missions flown in simulators, rotorpy and a compiled one: vehicles, commands, disturbances, and what came of it."""
