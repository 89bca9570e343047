"""``skinviz compare``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import Steps, progress_bar, say, say_files, say_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinviz.study.comparison import Comparison
    from skinviz.study.study import Study

TITLES = {
    "hands": "Hands",
    "colours": "Colours",
    "weights": "Weights",
    "spectra": "Spectra",
}
"""What the report calls each figure."""


def compare(
    study: Path | None = None,
    /,
    *,
    by: str,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    archive: str | None = None,
    group: tuple[str, ...] = (),
    site: tuple[str, ...] = (),
    origin: tuple[str, ...] = (),
    sex: tuple[str, ...] = (),
    level: tuple[str, ...] = (),
    model: str = "two-layer",
    coefficients: str = "effective",
    illuminant: str = "D65",
    no_hands: bool = False,
    strict: bool = False,
    seed: Whole = 0,
    json: bool = False,
) -> None:
    """Compare the sites, conditions, groups or subjects of a study.

    Every spectrum is fitted. Tables of means with 95 % intervals, of differences with
    effect sizes and corrected p-values, and of colour differences are written, with
    figures of spectra, weights and colours, hands side by side, and report.md, which
    has them all.

    Example: skinviz compare docs/examples/study --by condition --out compared

    Parameters
    ----------
    study
        Folder with study.toml and the files that it names.
    by
        What to compare: site, condition, group or subject. Sites and conditions are
        else kept apart.
    out
        Folder to write into; made if it does not exist.
    archive
        An archive instead of a study: issa, nist or a .nc file.
    group
        Only people of this group of the archive; may be given several times, as the
        next three.
    site
        Only spectra of this body site of the archive.
    origin
        Only spectra that this laboratory of the archive measured.
    sex
        Only people of this sex in the archive, F or M.
    level
        Only this level of what is compared; once for each.
    model
        Skin model to fit.
    coefficients
        Coefficient set: effective, textbook, or the .csv table of your own.
    illuminant
        Light on the hands.
    no_hands
        Leave the hands out, which take most of the time.
    strict
        Stop if anything of the study is missing or cannot be used, instead of listing
        it.
    seed
        Of the random draws behind the uncertainty of colours.
    json
        Print what was found as JSON.
    """
    from skinviz.errors import SkinvizError
    from skinviz.spectra.illuminants import as_illuminant
    from skinviz.study.comparing import compare_study
    from skinviz.study.comparison_report import attribution
    from skinviz.view.comparison_figures import comparison_figures

    if out.exists() and not out.is_dir():
        raise SkinvizError(f"--out {out} is a file; name a folder")
    as_illuminant(illuminant)
    choice = {"group": group, "site": site, "origin": origin, "sex": sex}
    with progress_bar(4 + (not no_hands)) as begin:
        begin("read")
        given = _given(study, archive, choice)
        begin("fit")
        found = compare_study(
            given,
            by,
            levels=level,
            model=model,
            coefficients=coefficients,
            seed=seed,
            advance=begin.counting(int(given.spectra.sizes["record"])),
        )
        if strict:
            found.require_whole()
        begin("draw figures")
        caption = attribution(found)
        figures = comparison_figures(found, caption)
        notes: tuple[str, ...] = ()
        if not no_hands:
            hands, notes = _hands(found, caption, illuminant, begin)
            figures = {"hands": hands, **figures}
        begin("write")
        files = write_comparison(out, found, figures, notes)
    if json:
        from skinviz.study.comparison_tables import as_data

        told = {**as_data(found), "notes": list(notes)}
        say_json({**told, "files": [str(file) for file in files]})
        return
    _say(found, notes)
    say_files(files)


def _given(
    folder: Path | None, archive: str | None, choice: dict[str, tuple[str, ...]]
) -> Study:
    """Return the study in a folder or an archive, whichever is named."""
    from skinviz.errors import ArgumentError
    from skinviz.study.archive_study import archive_study
    from skinviz.study.study_file import read_study

    if (folder is None) == (archive is None):
        raise ArgumentError("name one: the folder of a study, or --archive")
    asked: dict[str, Any] = {key: words for key, words in choice.items() if words}
    if archive is not None:
        return archive_study(archive, **asked)
    assert folder is not None  # noqa: S101 - one of the two is named
    if asked:
        raise ArgumentError(
            f"--{next(iter(asked))} chooses from an --archive; of a study choose "
            "levels with --level, or leave records out of its list"
        )
    return read_study(folder)


def _hands(
    found: Comparison, caption: str, illuminant: str, begin: Steps
) -> tuple[Figure, tuple[str, ...]]:
    """Return the figure of hands and what could not be had for it."""
    from skinviz.view.comparison_hands import comparison_hands

    begin("draw hands")
    made = comparison_hands(
        found,
        caption,
        illuminant=illuminant,
        advance=begin.counting(len(found.cells)),
    )
    return made.figure, made.notes


def write_comparison(
    folder: Path,
    found: Comparison,
    figures: dict[str, Figure],
    notes: tuple[str, ...],
) -> list[Path]:
    """Write tables, figures and the report into a folder: all of them or none."""
    import json

    from skinviz import __version__
    from skinviz._files import whole_files
    from skinviz.study import comparison_tables as tables
    from skinviz.study.comparison_report import report
    from skinviz.view.figures import save_figure

    pictures = {f"{TITLES[name]}": f"{name}.png" for name in TITLES if name in figures}
    texts = {
        "report.md": report(found, pictures, notes, __version__),
        "means.csv": tables.as_csv(tables.mean_rows(found)),
        "differences.csv": tables.as_csv(tables.difference_rows(found)),
        "colours.csv": tables.as_csv(tables.colour_rows(found)),
        "levels.csv": tables.as_csv(tables.level_rows(found)),
        "spectra.csv": tables.as_csv(tables.spectrum_rows(found)),
        "gaps.csv": tables.as_csv(tables.gap_rows(found.gaps)),
        "comparison.json": json.dumps(
            {**tables.as_data(found), "notes": list(notes)}, indent=2, allow_nan=False
        )
        + "\n",
    }
    drawn = {
        f"{name}.{suffix}": figure
        for name, figure in figures.items()
        for suffix in ("png", "svg")
    }
    files = [folder / name for name in (*texts, *drawn)]
    with whole_files(*files) as partials:
        for partial, text in zip(partials, texts.values(), strict=False):
            partial.write_text(text, "utf-8")
        for partial, figure in zip(partials[len(texts) :], drawn.values(), strict=True):
            save_figure(figure, partial)
    return files


def _say(found: Comparison, notes: tuple[str, ...]) -> None:
    """Say what was compared, the weights, and how much differs and is missing."""
    from skinviz.cli.text_table import Column, table
    from skinviz.study.comparison_report import mean_text

    say(f"{found.study.title}: {found.study.spectra.sizes['record']} spectra")
    n_weights = len(found.cells[0].fit.parameters)
    for stratum in found.strata:
        cells = found.row(stratum)[:40]
        columns = [Column("n", [str(len(cell.units)) for cell in cells])]
        columns += [
            Column(quantity.name, [mean_text(cell.means[k]) for cell in cells])
            for k, quantity in enumerate(found.quantities[:n_weights])
        ]
        for line in table(str(stratum), [cell.level for cell in cells], columns):
            say(line)
    tested = [c.p_holm for c in found.contrasts if c.p_holm is not None]
    sure = sum(p < 0.05 for p in tested)
    say(
        f"{sure} of {len(tested)} differences tested have p < 0.05 after Holm's "
        f"correction; {len(found.contrasts) - len(tested)} cannot be tested"
    )
    if found.gaps:
        say(f"gaps: {len(found.gaps)}, the first {found.gaps[0]}; gaps.csv has all")
    for note in notes:
        say(f"note: {note}")
