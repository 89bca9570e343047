"""The errors that skinviz raises: one tree, told in one line with what to do.

What does not belong here: warnings, and the status of a fit (that is data, in
:class:`skinviz.SkinFit`).
"""


class SkinvizError(Exception):
    """Base of every error that skinviz raises on purpose."""


class ArgumentError(SkinvizError, ValueError):
    """A function was called with an argument outside what it documents."""


class DataError(SkinvizError):
    """A file of spectra, coefficients or a scene is missing, broken or unfit."""


class MeshError(SkinvizError):
    """A scan or mesh is missing, broken or unfit, or its cleaning failed."""


class FitError(SkinvizError):
    """A fit did not converge, raised only by ``raise_for_status``."""


class SystemLibraryError(SkinvizError):
    """A system library that drawing or mesh repair needs is not installed."""


class SceneWarning(UserWarning):
    """A scene that can be computed, but hardly as its maker meant it."""
