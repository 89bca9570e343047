"""Tolerances by name, each with its reason. All are relative unless said."""

EPS = 2.0**-52

ROUNDING = 1e-13
"""The same algebra in another order."""

ORACLE = 1e-12
"""Another formula, at 60 digits or more: what the package declares."""

QUADRATURE = 1e-10
"""A smooth integral by another rule."""

KINKED_QUADRATURE = 5e-4
"""A hemispherical integral with edges (shadows, masking) by a product rule."""

TABLE = 5e-6
"""Half a unit of the sixth printed digit of the shipped tables."""

SAME_OPTIMUM = 1e-6
"""Sums of squares of two solvers at one minimum."""

NORMAL = 2.3e-308
"""Smallest float with all its digits; below it only the absolute size is right."""
