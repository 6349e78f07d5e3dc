"""Pages, figures and films of scenarios, missions and flights: what is drawn is a scene, which is data first."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
