"""How a spectrum was measured, in the words that files and models share."""

from __future__ import annotations

from skinviz._validate import in_range, one_of

EXCLUDED, INCLUDED = "excluded", "included"
"""45/0 and the like leave the surface reflection out; a closed sphere has it in."""

_HIGHEST_CONSTANT = 0.5


def as_specular(value: str | float) -> str | float:
    """Return how the surface reflection was measured, a number as float.

    Parameters
    ----------
    value : {"excluded", "included"} or number
        A number, also as text, is a constant surface reflection. [1], 0 to 0.5

    Raises
    ------
    ArgumentError
        If it is another word, or a number outside [0, 0.5].
    """
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            return one_of(value, (EXCLUDED, INCLUDED), "specular (or a number)")
    return in_range(value, 0.0, _HIGHEST_CONSTANT, "specular")
