"""``skinviz compare``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import Steps, progress_bar, say_files, say_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from skinviz.study.comparison import Comparison
    from skinviz.study.study import Study


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
    like: tuple[str, ...] = (),
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
    like
        SITE=SITE, as palm=cheek, for a site of the archive that Table I lacks: whose
        thickness of skin to take; once for each.
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
    from skinviz.cli.compare_output import say_comparison, write_comparison
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
        given = _given(study, archive, choice, like)
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
    say_comparison(found, notes)
    say_files(files)


def _given(
    folder: Path | None,
    archive: str | None,
    choice: dict[str, tuple[str, ...]],
    like: tuple[str, ...],
) -> Study:
    """Return the study in a folder or an archive, whichever is named."""
    from skinviz.errors import ArgumentError
    from skinviz.study.archive_study import archive_study
    from skinviz.study.study_file import read_study

    if (folder is None) == (archive is None):
        raise ArgumentError("name one: the folder of a study, or --archive")
    asked: dict[str, Any] = {key: words for key, words in choice.items() if words}
    if archive is not None:
        return archive_study(archive, **asked, sites=_likes(like))
    assert folder is not None  # noqa: S101 - one of the two is named
    if asked or like:
        raise ArgumentError(
            f"--{next(iter(asked), 'like')} is for an --archive; of a study choose "
            "levels with --level, and say the rest in its study.toml"
        )
    return read_study(folder)


def _likes(words: tuple[str, ...]) -> dict[str, dict[str, str]]:
    """Return SITE=SITE words by the first site."""
    from skinviz.errors import ArgumentError

    likes = {}
    for word in words:
        site, mark, other = (part.strip() for part in word.partition("="))
        if not (site and mark and other):
            raise ArgumentError(f"--like takes SITE=SITE; got {word!r}")
        likes[site] = {"like": other}
    return likes


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
