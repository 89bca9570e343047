"""Write the observers' and illuminants' tables from colour-science's data.

Run once, with the development environment: ``python scripts/make_colour_tables.py``.
"""

import csv
from pathlib import Path

import colour
import numpy as np

DATA = Path(__file__).parents[1] / "skinviz" / "spectra" / "data"
OBSERVERS = (
    "CIE 1931 2 Degree Standard Observer",
    "CIE 1964 10 Degree Standard Observer",
)
ILLUMINANTS = (
    *("A", "C", "D50", "D55", "D65", "D75", "E"),
    *(f"FL{i}" for i in range(1, 13)),
    *(f"LED-B{i}" for i in range(1, 6)),
    *("LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"),
)


def write(name: str, header: list[str], columns: list[np.ndarray]) -> None:
    """Write one table as CSV with the shortest numbers that read back the same."""
    with (DATA / name).open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(header)
        for row in zip(*columns, strict=True):
            rows.writerow([f"{value:.10g}" for value in row])


def main() -> None:
    """Write both tables."""
    fine = np.arange(360.0, 831.0)
    # The library's rounding leaves -1e-20 at two wavelengths where the CIE has 0.
    functions = [np.maximum(colour.MSDS_CMFS[name][fine], 0.0) for name in OBSERVERS]
    write(
        "cie_cmfs_1nm.csv",
        ["wavelength_nm", "x_1931", "y_1931", "z_1931", "x_1964", "y_1964", "z_1964"],
        [fine, *functions[0].T, *functions[1].T],
    )
    coarse = np.arange(380.0, 781.0, 5.0)
    powers = [colour.SDS_ILLUMINANTS[name][coarse] for name in ILLUMINANTS]
    write("cie_illuminants_5nm.csv", ["wavelength_nm", *ILLUMINANTS], [coarse, *powers])


if __name__ == "__main__":
    main()
