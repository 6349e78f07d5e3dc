"""Missions that people have: read, proven as their autopilots fly them, and repaired."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
