"""Missions flown in simulators, rotorpy and a compiled one: vehicles, commands, disturbances, and what came of it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
