"""Spectra and colour: grids, illuminants, colorimetry, files, archives."""
