"""Studies: planners compared over scenarios, seeds and budgets, and replanning policies among movers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
