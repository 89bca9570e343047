"""``skinviz fit``."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.output import progress_bar, say, say_files, say_json, write_json

if TYPE_CHECKING:
    from skinviz.skin.skin_fit import SkinFit

_PLOTTED = 4  # spectra in a plot: more would be too small to read


def fit(
    file: Path,
    /,
    *,
    site: str | None = None,
    thickness: tuple[float, float] | None = None,
    specular: str | None = None,
    model: str = "two-layer",
    coefficients: str = "effective",
    scale: str = "fraction",
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    plot: Path | None = None,
    json: bool = False,
) -> None:
    """Fit pigment weights to measured skin spectra.

    Example: skinviz fit hand.csv --site "back of hand" --specular included -o fit.json

    Parameters
    ----------
    file
        CSV file of reflectance, wavelengths down or across, spanning 400-700 nm.
    site
        Body site whose layer thickness to use: cheek, back of hand, outer arm,
        inner arm.
    thickness
        Thickness of epidermis and dermis in mm, instead of a site.
    specular
        How the surface reflection was measured: excluded (45/0), included (sphere),
        or a number. Needed unless the file states it.
    model
        Skin model.
    coefficients
        Coefficient set: effective or textbook.
    scale
        fraction for reflectance 0-1, percent for 0-100.
    out
        File to write: .json (which a scene can name) or .csv.
    plot
        Figure of the first spectra to write, up to four: .png, .svg or .pdf.
    json
        Print the fit as JSON.
    """
    from skinviz._validate import one_of
    from skinviz.errors import ArgumentError, DataError
    from skinviz.skin.fit import fit_skin
    from skinviz.skin.models import skin_model
    from skinviz.skin.report import fit_to_dict
    from skinviz.spectra.files import read_spectra

    if out is not None:
        one_of(out.suffix.lower(), (".json", ".csv"), "suffix of --out")
    if plot is not None:
        one_of(plot.suffix.lower(), (".png", ".svg", ".pdf"), "suffix of --plot")
    files: list[Path] = []
    with progress_bar(3) as begin:
        begin("read")
        spectra = read_spectra(file, scale=scale, specular=specular)
        if "specular" not in spectra.attrs:
            raise DataError(
                f"{file} does not say how the surface reflection was measured; say "
                "--specular excluded, included or a number"
            )
        chosen = skin_model(
            model,
            specular=spectra.attrs["specular"],
            site=site,
            thickness=thickness,
            coefficients=coefficients,
        )
        begin("fit")
        labels = [str(label) for label in spectra.label.values]
        try:
            found = fit_skin(
                spectra.reflectance.values, spectra.wavelength.values, chosen
            )
        except ArgumentError as error:
            raise DataError(f"{file}: {error}") from error
        result = {"file": str(file), "site": site, **fit_to_dict(found, labels)}
        begin("write")
        if out is not None:
            files.append(
                write_json(out, result)
                if out.suffix.lower() == ".json"
                else _write_csv(out, result)
            )
        if plot is not None:
            files.append(_write_plot(plot, spectra, found, labels))
    if json:
        say_json({**result, "files": [str(path) for path in files]})
    else:
        say(_table(found, labels))
        say_files(files)


def _table(found: SkinFit, labels: list[str]) -> str:
    """Return the fits as a table, one line a spectrum."""
    from skinviz.skin.skin_fit import REFUSED, WHY_REFUSED

    width = max(len("spectrum"), *(len(label) for label in labels))
    names = "".join(f"{name:>26}" for name in found.parameters)
    lines = [f"{'spectrum':<{width}}{names}     SSE   dE00  status"]
    for i, label in enumerate(labels):
        weights = "".join(
            f"{value:9.4f} [{low:.4f}, {high:.4f}]"
            for value, (low, high) in zip(
                found.values[i], found.interval[i], strict=True
            )
        )
        lines.append(
            f"{label:<{width}}{weights} {found.sse[i]:7.4f} {found.delta_e[i]:6.2f}"
            f"  {found.status[i]}"
        )
    if (found.status == REFUSED).any():
        lines.append(f"{REFUSED}: {WHY_REFUSED}")
    return "\n".join(lines)


def _write_csv(path: Path, result: dict[str, Any]) -> Path:
    """Write the fits as CSV, one line a spectrum."""
    from skinviz._files import whole_file

    with (
        whole_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as text,
    ):
        rows = csv.writer(text, lineterminator="\n")
        records = [_flat(entry) for entry in result["fits"]]
        rows.writerow(records[0])
        rows.writerows(record.values() for record in records)
    return path


def _flat(entry: dict[str, Any]) -> dict[str, Any]:
    """Return a fit's data with one column a number; None becomes an empty cell."""
    flat: dict[str, Any] = {}
    for key, value in {**entry, **entry["parameters"]}.items():
        if key == "parameters":
            continue
        if isinstance(value, dict):
            flat |= {f"{key}_{side}": number for side, number in value.items()}
        else:
            flat[key] = value
    return flat


def _write_plot(path: Path, spectra: Any, found: SkinFit, labels: list[str]) -> Path:
    """Draw the first spectra with their fits and residuals."""
    from skinviz.view.figures import Site, save_figure, sites_figure

    measured = spectra.reflectance.sel(wavelength=found.wavelengths).values
    sites = [
        Site(label, measured[i], found[i]) for i, label in enumerate(labels[:_PLOTTED])
    ]
    described = found.model.description
    title = f"{described['model']} model, {described['coefficients']} coefficients"
    caption = f"specular {found.model.specular}; {spectra.attrs['source']}"
    return save_figure(sites_figure(sites, title, caption), path)
