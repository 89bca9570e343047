"""The certificate of a white tile: its own radiance factor, and how sure that is."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skinviz._files import existing_file
from skinviz.errors import DataError

Array = NDArray[np.float64]

FACTOR, UNCERTAINTY = "factor", "uncertainty"
"""Names of the columns of a certificate."""

_VISIBLE = (380.0, 780.0)  # nm, which all meters measure


@dataclass(frozen=True, eq=False)
class Certificate:
    """What a laboratory says of a white tile.

    Attributes
    ----------
    wavelengths, factor, uncertainty : (n,) ndarray
        [nm], radiance factor [1], its standard uncertainty [1].
    source : str
        Name of the file that it was read from.
    sha256 : str
        Of that file.
    """

    wavelengths: Array
    factor: Array
    uncertainty: Array
    source: str
    sha256: str

    def at(self, wavelengths: Array) -> tuple[Array, Array]:
        """Return factor and uncertainty (n,) on a line between the certificate's.

        NaN outside it: nothing is said there.
        """
        outside = {"left": np.nan, "right": np.nan}
        return (
            np.interp(wavelengths, self.wavelengths, self.factor, **outside),
            np.interp(wavelengths, self.wavelengths, self.uncertainty, **outside),
        )

    def to_json(self) -> dict[str, Any]:
        """Return it as a session's log keeps it."""
        return {
            "wavelengths": self.wavelengths.tolist(),
            "factor": self.factor.tolist(),
            "uncertainty": self.uncertainty.tolist(),
            "source": self.source,
            "sha256": self.sha256,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Self:
        """Return what :meth:`to_json` kept.

        Raises
        ------
        DataError
            If it was not that.
        """
        names = ("wavelengths", "factor", "uncertainty")
        try:
            nm, factor, u = (np.array(data[name], dtype=np.float64) for name in names)
            found = cls(nm, factor, u, str(data["source"]), str(data["sha256"]))
        except (KeyError, TypeError, ValueError) as error:
            raise DataError(
                "the white's certificate in the log is none; read the log with the "
                "version that wrote it"
            ) from error
        if not nm.ndim == 1 <= nm.size or not nm.shape == factor.shape == u.shape:
            raise DataError("the columns of the log's certificate differ in length")
        return found


def read_certificate(path: str | os.PathLike[str]) -> Certificate:
    """Read the certificate of a white tile.

    Parameters
    ----------
    path : path-like
        A table of spectra as :func:`skinviz.read_spectra` reads it, as CSV with the
        header ``wavelength_nm,factor,uncertainty``; the uncertainty is the standard
        one, half of what most laboratories print (k = 2).

    Raises
    ------
    DataError
        If it has other columns, or values that no white tile has.
    """
    from skinviz.spectra.files import read_spectra

    file = existing_file(path, DataError)
    table = read_spectra(file)
    names = [] if "label" not in table.coords else table["label"].values.tolist()
    if sorted(names) != [FACTOR, UNCERTAINTY]:
        raise DataError(
            f"{file}: a white's certificate has the columns {FACTOR} and "
            f"{UNCERTAINTY} (standard, 0-1); got {', '.join(names)[:80] or 'others'}"
        )
    values = dict(zip(names, table["reflectance"].values, strict=True))
    factor, uncertainty = values[FACTOR], values[UNCERTAINTY]
    if not (factor > 0.02).all() or not (uncertainty < 0.1 * factor).all():
        raise DataError(
            f"{file}: a white's factor is above 0.02 and its uncertainty below a tenth "
            f"of it; got {factor.min():g} and {uncertainty.max():g}"
        )
    wavelengths = table["wavelength"].values.astype(np.float64)
    if wavelengths[-1] < _VISIBLE[0] or wavelengths[0] > _VISIBLE[1]:
        raise DataError(
            f"{file}: a white's certificate is needed for {_VISIBLE[0]:g}-"
            f"{_VISIBLE[1]:g} nm, in nm; got {wavelengths[0]:g}-{wavelengths[-1]:g}"
        )
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    return Certificate(wavelengths, factor, uncertainty, file.name, digest)
