"""Plan, prove, fly and export 3-D missions for fleets of UAVs.

The public names load when first used, so that importing skyverse costs nothing.
"""

import lazy_loader

from skyverse.draw.notebooks import show_in_notebooks

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name in __all__:
        from skyverse.extras import told_imports

        with told_imports():
            return _loaded(name)
    if name.startswith("_"):  # asked for by tools that look into modules, again and again
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from skyverse.errors import did_you_mean

    raise AttributeError(f"module {__name__!r} has no attribute {name!r}{did_you_mean(name, __all__)}")


show_in_notebooks()
