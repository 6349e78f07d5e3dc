"""Missions in flight: what is seen comes in, and a motion that is proven to have a way out goes out."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
