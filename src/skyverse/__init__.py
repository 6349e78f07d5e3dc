"""Plan, prove, fly and export 3-D missions for fleets of UAVs.

The public names load when first used, so that importing skyverse costs nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
