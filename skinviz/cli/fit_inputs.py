"""What ``skinviz fit`` is given: read, and refused before a long fit is in vain."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from skinviz.cli.output import Steps

if TYPE_CHECKING:
    import numpy as np
    import xarray
    from numpy.typing import NDArray

PICTURES = (".png", ".svg", ".pdf")
"""What a figure can be written as."""

# Spectra: JSON is read whole by whoever reads it; spreadsheets hold 2^20 rows.
MOST = {".json": 100_000, ".csv": 1_000_000}
"""Spectra that a file of a suffix may hold."""


def require_outputs(
    inputs: Sequence[Path],
    out: Path | None,
    plot: Path | None,
    maps: Path | None,
    models: Sequence[str],
) -> None:
    """Refuse, before anything is read, what could not be written in the end."""
    from skinviz._validate import one_of
    from skinviz.errors import ArgumentError
    from skinviz.skin.fit_files import FIT_SUFFIXES

    asked = (("--out", out, FIT_SUFFIXES), ("--plot", plot, PICTURES))
    for option, path, suffixes in (*asked, ("--maps", maps, PICTURES)):
        if path is None:
            continue
        one_of(path.suffix.lower(), suffixes, f"suffix of {option}")
        if path.resolve() in {file.resolve() for file in inputs}:
            raise ArgumentError(f"{option} {path} is a file to be fitted; name another")
    for what, names in (("file", map(str, inputs)), ("--model", models)):
        name, times = Counter(names).most_common(1)[0]
        if times > 1:
            raise ArgumentError(f"{what} {name} is given {times} times; give it once")
    if maps is not None and len(models) > 1:
        raise ArgumentError(
            f"--maps shows one model and {len(models)} are given; map them one by one, "
            "or write all with -o FILE.hdr"
        )


def read_files(
    files: Sequence[Path], scale: str | None, specular: str | None, begin: Steps
) -> dict[Path, xarray.Dataset]:
    """Return the files' spectra, all measured in one way."""
    from skinviz.errors import DataError
    from skinviz.spectra.files import read_spectra

    read: dict[Path, xarray.Dataset] = {}
    for file in files:
        begin(f"read {file.name}")
        spectra = read_spectra(file, scale=scale, specular=specular)
        if "specular" not in spectra.attrs:
            raise DataError(
                f"{file} does not say how the surface reflection was measured; say "
                "--specular excluded, included or a number"
            )
        how = spectra.attrs["specular"]
        for other, known in read.items():
            if known.attrs["specular"] != how:
                raise DataError(
                    f"{other} was measured with specular {known.attrs['specular']} and "
                    f"{file} with {how}; fit them in runs of their own"
                )
        read[file] = spectra
    return read


def require_kinds(
    spectra: dict[Path, xarray.Dataset],
    out: Path | None,
    plot: Path | None,
    maps: Path | None,
) -> None:
    """Refuse, before anything is fitted, outputs that do not suit the files."""
    from skinviz.errors import ArgumentError
    from skinviz.skin.fit_files import require_free

    cubes = [file for file, own in spectra.items() if is_cube(own)]
    one_cube = len(cubes) == len(spectra) == 1
    if plot is not None and cubes:
        raise ArgumentError(
            f"--plot draws lists of spectra, and {cubes[0]} is a cube; use --maps"
        )
    if maps is not None and not one_cube:
        raise ArgumentError(
            f"--maps draws one cube; {_kinds(cubes, spectra)}"
            + ("" if cubes else "; use --plot")
        )
    if out is None:
        return
    suffix = out.suffix.lower()
    if suffix == ".hdr" and not one_cube:
        raise ArgumentError(
            f"{out}: an ENVI header holds the maps of one cube; "
            f"{_kinds(cubes, spectra)}; write .csv, .json or .nc"
        )
    if suffix == ".hdr":
        require_free(out)
    if suffix == ".nc" and cubes and not one_cube:
        raise ArgumentError(
            f"{out}: netCDF holds lists, or one cube; {_kinds(cubes, spectra)}; fit "
            "each cube in a run of its own"
        )
    size = sum(count(own) for own in spectra.values())
    if size > MOST.get(suffix, size):
        raise ArgumentError(
            f"{out}: {size} spectra are too many for {suffix}, at most "
            f"{MOST[suffix]}; write .nc" + (" or .hdr" if one_cube else "")
        )


def uncertainty_of(
    spectra: xarray.Dataset, given: float | None
) -> tuple[NDArray[np.float64] | None, float]:
    """Return the standard deviation of each band, and what share all bands share.

    What is given, or else the file's own; in bands without a reflectance it is 1, as
    any number would do.
    """
    import numpy as np

    from skinviz._validate import in_range
    from skinviz.skin.scale_error import LARGEST_SCALE_ERROR

    reflectance = spectra["reflectance"]
    if given is not None:
        return np.full(spectra.sizes["wavelength"], given), 0.0
    own = spectra.get("uncertainty")
    if own is None or own.attrs.get("units") != "1":
        return None, 0.0
    if set(own.dims) != set(reflectance.dims):
        return None, 0.0
    aligned = own.transpose(*reflectance.dims).values.astype(np.float64)
    known = np.isfinite(reflectance.values)
    name = "scale_uncertainty"
    scale = in_range(spectra.attrs.get(name, 0.0), 0.0, LARGEST_SCALE_ERROR, name)
    return np.where(known, aligned, 1.0), scale


def is_cube(spectra: xarray.Dataset) -> bool:
    """Return whether spectra are a cube, not a list."""
    return "sample" in spectra.sizes


def count(spectra: xarray.Dataset) -> int:
    """Return how many spectra there are."""
    return int(spectra["reflectance"].size // spectra.sizes["wavelength"])


def _kinds(cubes: Sequence[Path], spectra: dict[Path, xarray.Dataset]) -> str:
    """Return what was given instead, in words."""
    return f"given are {len(cubes)} cubes and {len(spectra) - len(cubes)} lists"
