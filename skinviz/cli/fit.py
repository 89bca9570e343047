"""``skinviz fit``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.fit_inputs import (
    MOST,
    count,
    is_cube,
    read_files,
    require_kinds,
    require_outputs,
    uncertainty_of,
)
from skinviz.cli.output import (
    Steps,
    progress_bar,
    say,
    say_files,
    say_json,
    write_json,
)

if TYPE_CHECKING:
    import xarray

    from skinviz.skin.fitted import Fitted
    from skinviz.skin.model import SkinModel

_PLOTTED = 4  # spectra in a plot: more would be too small to read


def fit(
    *file: Annotated[Path, Parameter(required=True)],
    site: str | None = None,
    thickness: tuple[float, float] | None = None,
    specular: str | None = None,
    model: tuple[str, ...] = ("two-layer",),
    free: tuple[str, ...] = (),
    coefficients: str = "effective",
    scale: str | None = None,
    uncertainty: float | None = None,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    plot: Path | None = None,
    maps: Path | None = None,
    all: bool = False,
    json: bool = False,
) -> None:
    """Fit pigment weights to measured skin spectra, or to a cube of them.

    Example: skinviz fit hand.csv --site "back of hand" --specular included -o fit.json

    Parameters
    ----------
    file
        Files of reflectance spanning 400-700 nm: .csv, .tsv, .spdx, .cgats, .txt, .nc,
        or the .hdr of an ENVI cube. All of one run are fitted with the same models.
    site
        Body site whose layer thickness to use: cheek, back of hand, outer arm,
        inner arm.
    thickness
        Thickness of epidermis and dermis in mm, instead of a site.
    specular
        How the surface reflection was measured: excluded (45/0), included (sphere),
        or a number. Needed unless the files state it.
    model
        Skin model. Give several, once each, to compare them by their BIC.
    free
        What the extended model leaves free besides the pigments: scattering,
        melanin_slope, surface, epidermis, once each; the first three if not said.
    coefficients
        Coefficient set: effective, textbook, or the .csv table of your own.
    scale
        fraction for reflectance 0-1, percent for 0-100, where the files do not say it.
    uncertainty
        Standard deviation of a band, as reflectance 0-1. The intervals then follow
        from it, not from the residuals; so they do where a .nc has uncertainties.
    out
        File to write: .json (which a scene can name), .csv (a row a spectrum), .nc
        (all of it), or .hdr (maps of a cube as an ENVI file).
    plot
        Figure of the first spectra to write, up to four: .png, .svg or .pdf.
    maps
        Figure of a cube's maps to write: .png, .svg or .pdf.
    all
        Print every spectrum where a summary would be printed, of more than 40.
    json
        Print the fit as JSON; of more than 100,000 spectra a summary alone.
    """
    from skinviz.cli.fit_text import fit_lines, summary

    require_outputs(file, out, plot, maps, model)
    n_written = sum(path is not None for path in (out, plot, maps))
    steps = len(file) * (1 + len(model)) + n_written
    with progress_bar(steps) as begin:
        spectra = read_files(file, scale, specular, begin)
        require_kinds(spectra, out, plot, maps)
        tissue = {"site": site, "thickness": thickness, "coefficients": coefficients}
        chosen = _models(model, spectra, free, **tissue)
        run = _fit(spectra, chosen, uncertainty, begin)
        files = []
        if out is not None:
            begin(f"write {out.name}")
            files.append(_write(out, run, site))
        if plot is not None:
            begin(f"draw {plot.name}")
            files.append(_plot(plot, run))
        if maps is not None:
            begin(f"draw {maps.name}")
            files.append(_map(maps, run))
    if not json:
        for line in fit_lines(run, every=all):
            say(line)
        say_files(files)
        return
    few = sum(item.fits[0].status.size for item in run) <= MOST[".json"]
    told = _result(run, site) if few else {}
    say_json({**told, "summary": summary(run), "files": [str(path) for path in files]})


def _models(
    names: Sequence[str],
    spectra: dict[Path, xarray.Dataset],
    free: Sequence[str],
    **tissue: Any,
) -> list[SkinModel]:
    """Return the models, built for what was measured; one takes what is free."""
    from skinviz.errors import ArgumentError
    from skinviz.skin.models import skin_model

    specular = next(iter(spectra.values())).attrs["specular"]
    if free and "extended" not in names:
        raise ArgumentError("--free is for --model extended; say both, or neither")
    options: dict[str, Any] = {"extended": {"free": free}} if free else {}
    return [
        skin_model(name, specular=specular, **tissue, **options.get(name, {}))
        for name in names
    ]


def _fit(
    spectra: dict[Path, xarray.Dataset],
    models: Sequence[SkinModel],
    uncertainty: float | None,
    begin: Steps,
) -> list[Fitted]:
    """Return each file's spectra with what each model made of them."""
    import numpy as np

    from skinviz.errors import ArgumentError, DataError
    from skinviz.skin.fit import fit_skin
    from skinviz.skin.fitted import GRID, Fitted
    from skinviz.skin.scale_error import fit_uncertain_scale

    if uncertainty is not None and not (0 < uncertainty < np.inf):
        raise ArgumentError(
            f"--uncertainty must be above 0, as reflectance 0-1; got {uncertainty:g}"
        )
    run = []
    for file, own in spectra.items():
        dims = GRID if is_cube(own) else ("record",)
        data = own["reflectance"].transpose(*dims, "wavelength").values
        bands = own["wavelength"].values
        sigma, scale = uncertainty_of(own, uncertainty)
        fits = []
        for model in models:
            begin(f"fit {model.name}" + (f", {file.name}" if len(spectra) > 1 else ""))
            advance = begin.counting(count(own))
            try:
                fits.append(
                    fit_uncertain_scale(
                        data,
                        bands,
                        model,
                        uncertainty=sigma,
                        scale=scale,
                        advance=advance,
                    )
                    if scale
                    else fit_skin(
                        data, bands, model, uncertainty=sigma, advance=advance
                    )
                )
            except ArgumentError as error:
                raise DataError(f"{file}: {error}") from error
        run.append(Fitted(str(file), _prefix(file, list(spectra)), own, tuple(fits)))
    return run


def _prefix(file: Path, files: Sequence[Path]) -> str:
    """Return what stands before a file's labels where there are several files."""
    if len(files) == 1:
        return ""
    stems = [other.stem for other in files]
    return f"{file.stem if stems.count(file.stem) == 1 else file}/"


def _result(run: Sequence[Fitted], site: str | None) -> dict[str, Any]:
    """Return what a JSON file of the run holds."""
    from skinviz.skin.fitted import as_data

    files = [item.file for item in run]
    return {"file": files if len(files) > 1 else files[0], "site": site, **as_data(run)}


def _write(out: Path, run: Sequence[Fitted], site: str | None) -> Path:
    """Write the fits in the format of the suffix."""
    from skinviz.skin import fit_files

    suffix = out.suffix.lower()
    if suffix == ".json":
        return write_json(out, _result(run, site))
    if suffix == ".csv":
        return fit_files.write_fit_rows(out, run)
    if suffix == ".hdr":
        return fit_files.write_fit_maps(out, run[0])
    facts = {"source": ", ".join(item.file for item in run)}
    return fit_files.write_fit_dataset(
        out, run, facts if site is None else facts | {"site": site}
    )


def _title(run: Sequence[Fitted]) -> str:
    """Return what a figure shows."""
    models = [fit.model for fit in run[0].fits]
    names = ", ".join(model.name for model in models)
    table = Path(models[0].coefficients.name).name
    return f"{names} model{'s' if len(models) > 1 else ''}, {table} coefficients"


def _caption(run: Sequence[Fitted]) -> str:
    """Return how the figure's spectra were measured and where they are from."""
    sources = ", ".join(str(item.spectra.attrs["source"]) for item in run)
    return f"specular {run[0].fits[0].model.specular}; {sources}"


def _plot(path: Path, run: Sequence[Fitted]) -> Path:
    """Draw the first spectra with their fits and residuals."""
    from skinviz.view.figures import save_figure
    from skinviz.view.fits_figure import FittedSpectrum, fits_figure

    shown = [
        FittedSpectrum(label, measured, tuple(fit[i] for fit in item.fits))
        for item in run
        for i, (label, measured) in enumerate(
            zip(item.labels, item.measured, strict=True)
        )
    ]
    figure = fits_figure(shown[:_PLOTTED], _title(run), _caption(run))
    return save_figure(figure, path)


def _map(path: Path, run: Sequence[Fitted]) -> Path:
    """Draw the maps of a cube."""
    from skinviz.view.figures import save_figure
    from skinviz.view.pigment_maps import maps_figure

    (item,) = run
    figure = maps_figure(item.measured, item.fits[0], _title(run), _caption(run))
    return save_figure(figure, path)
