"""Missions as files for ground stations, maps, robots and light shows; the suffix of the file tells its format."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
