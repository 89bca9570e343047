"""Optics of skin: coefficients, layers, models and their fit to spectra."""
