"""``skinviz archive``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import cyclopts
from cyclopts import Parameter

from skinviz.cli.output import progress_bar, say, say_files, say_json

if TYPE_CHECKING:
    import xarray

archive = cyclopts.App(name="archive")
"""The verb with its sub-command ``import``."""


@archive.default
def show(
    name: str | None = None,
    /,
    *,
    site: str | None = None,
    group: str | None = None,
    origin: str | None = None,
    sex: str | None = None,
    subject: str | None = None,
    average: bool = False,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    json: bool = False,
) -> None:
    """List archives of measured skin, or what one holds, and write spectra from it.

    Example: skinviz archive issa --site "back of hand" --origin China -o hands.csv

    Parameters
    ----------
    name
        issa, nist, or a .nc file that skinviz archive import wrote. Without it, the
        shipped archives are listed.
    site
        Only spectra of this body site.
    group
        Only spectra of this group of people.
    origin
        Only spectra that this laboratory measured.
    sex
        Only spectra of this sex, F or M.
    subject
        Only spectra of this subject's number.
    average
        Leave duplicates out and average the repeats of a subject and site.
    out
        File to write the chosen spectra to. Bands that one of them lacks are left
        out.
    json
        Print it as JSON.
    """
    from skinviz.errors import ArgumentError
    from skinviz.spectra.archive_selection import average_repeats, select

    filters = {
        "site": site,
        "group": group,
        "origin": origin,
        "sex": sex,
        "subject": subject,
    }
    if name is None:
        if out is not None or average or any(f is not None for f in filters.values()):
            raise ArgumentError("name an archive to choose from: issa, nist or a file")
        _list_archives(json)
        return
    from skinviz.spectra.archives import load_archive

    chosen = load_archive(name)
    if average:
        chosen = average_repeats(chosen)
    chosen = select(chosen, **filters)
    facts = _facts(name, chosen)
    if out is not None:
        facts |= _write(out, chosen)
    _print(facts, json)


@archive.command(name="import")
def import_spreadsheet(
    spreadsheet: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    scale: str = "fraction",
    column: tuple[str, ...] = (),
    json: bool = False,
) -> None:
    """Turn the publisher's ISSA spreadsheet into an archive's file.

    Example: skinviz archive import ISSA.xlsx -o full.nc --scale percent

    Parameters
    ----------
    spreadsheet
        The full International Skin Spectra Archive, .xlsx (figshare 28228571.v4).
    out
        Archive to write, .nc.
    scale
        fraction for reflectance 0-1, percent for 0-100. The publisher's file is in
        per cent.
    column
        LABEL=HEADING or LABEL=LETTER for a column that is not found by itself, as
        site=G; once for each.
    json
        Print what was imported as JSON.
    """
    from skinviz._validate import one_of
    from skinviz.spectra.archive_file import SUFFIX, write_archive
    from skinviz.spectra.issa_import import import_archive

    one_of(out.suffix.lower(), (SUFFIX,), "suffix of --out")
    with progress_bar(4) as begin:
        imported = import_archive(
            spreadsheet, scale=scale, columns=_pairs(column), progress=begin
        )
        begin("write")
        file = write_archive(out, imported)
    facts = {**_facts(str(out), imported), "files": [str(file)]}
    _print(facts, json)


def _pairs(words: tuple[str, ...]) -> dict[str, str]:
    """Return LABEL=HEADING words as a mapping."""
    from skinviz.errors import ArgumentError

    pairs = {}
    for word in words:
        label, mark, heading = word.partition("=")
        if not (mark and label.strip() and heading.strip()):
            raise ArgumentError(f"--column takes LABEL=HEADING; got {word!r}")
        pairs[label.strip()] = heading.strip()
    return pairs


def _write(out: Path, chosen: xarray.Dataset) -> dict[str, Any]:
    """Write spectra; return the file and the bands left out."""
    from skinviz.spectra.archive_selection import common_bands, with_labels
    from skinviz.spectra.files import write_spectra

    whole = with_labels(common_bands(chosen))
    kept = set(whole["wavelength"].values)
    left = [float(nm) for nm in chosen["wavelength"].values if nm not in kept]
    return {"files": [str(write_spectra(out, whole))], "left_out_nm": left}


def _facts(name: str, chosen: xarray.Dataset) -> dict[str, Any]:
    """Return what an archive is and what it holds."""
    from skinviz.spectra.archive_summary import summary

    keys = ("source", "licence", "specular", "geometry", "unnamed_codes")
    said = {key: chosen.attrs[key] for key in keys if chosen.attrs.get(key)}
    return {"archive": name, **said, **summary(chosen)}


def _list_archives(json: bool) -> None:
    """Print what the shipped archives are."""
    from skinviz.spectra.archives import ARCHIVES, load_archive

    listed = [_facts(name, load_archive(name)) for name in ARCHIVES]
    if json:
        say_json(listed)
        return
    for facts in listed:
        say("\n".join(_head(facts)) + "\n")
    say("skinviz archive NAME shows groups, sites and counts.")


def _print(facts: dict[str, Any], json: bool) -> None:
    """Print what an archive holds, as JSON or as tables."""
    if json:
        say_json(facts)
        return
    for line in _head(facts):
        say(line)
    say("")
    for line in _table(facts):
        say(line)
    say("")
    for label in ("origin", "sex", "age_group"):
        counts = [
            f"{value} {n['spectra']}/{n['people']}" for value, n in facts[label].items()
        ]
        say(f"{label.replace('_', ' '):<12} {', '.join(counts)}")
    repeats = facts["repeats"]
    say(f"{'duplicates':<12} {facts['duplicates']}: the same under another person too")
    say(
        f"{'repeats':<12} {repeats['spectra']} spectra of {repeats['subject_sites']} "
        "subject-sites that have several"
    )
    say(f"{'two sexes':<12} {', '.join(facts['two_sexes']) or 'nobody'}")
    if facts.get("left_out_nm"):
        bands = ", ".join(f"{nm:g}" for nm in facts["left_out_nm"])
        say(f"{'left out':<12} {bands} nm, which not every spectrum has")
    say_files(Path(file) for file in facts.get("files", ()))


def _head(facts: dict[str, Any]) -> list[str]:
    """Return what an archive is, in lines."""
    ranges = [
        f"{r['from']:g}-{r['to']:g} nm ({r['spectra']})" for r in facts["wavelengths"]
    ]
    lines = {
        "archive": facts["archive"],
        "source": facts["source"],
        "licence": facts["licence"],
        "measured": f"specular {facts['specular']}, {facts['geometry']}",
        "unnamed": facts.get("unnamed_codes"),
        "holds": f"{facts['spectra']} spectra, {facts['people']} people, "
        f"{facts['sites']} sites",
        "wavelengths": ", ".join(ranges),
    }
    return [f"{name:<12} {text}" for name, text in lines.items() if text]


def _table(facts: dict[str, Any]) -> list[str]:
    """Return spectra/people by site, down, and group, across."""
    groups = list(facts["group"])
    rows = [
        [site, *(_pair(own.get(group)) for group in groups)]
        for site, own in facts["table"].items()
    ]
    totals = ["all", *(_pair(facts["group"][group]) for group in groups)]
    cells = [["spectra/people", *groups], *rows, totals]
    widths = [max(len(row[i]) for row in cells) for i in range(len(groups) + 1)]
    return [
        "  ".join(
            [row[0].ljust(widths[0])]
            + [cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True)]
        )
        for row in cells
    ]


def _pair(counts: dict[str, int] | None) -> str:
    """Return spectra/people, a dash for none."""
    return "-" if counts is None else f"{counts['spectra']}/{counts['people']}"
