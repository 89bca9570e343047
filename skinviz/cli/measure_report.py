"""What ``skinviz measure`` tells of a session."""

from __future__ import annotations

from typing import Any

import numpy as np

from skinviz.cli.text_table import Column, table
from skinviz.instruments.derive import Derived, spectra_of
from skinviz.instruments.lobe import lobe_of
from skinviz.instruments.skinlog import SkinLog
from skinviz.surface.lobe_fit import fit_lobe


def session_facts(session: SkinLog, derived: Derived) -> dict[str, Any]:
    """Return what is worth to know of a session."""
    plan = derived.frames.plan
    spectra = spectra_of(session, derived, "")
    rows = zip(
        spectra["label"].values,
        spectra["reflectance"].values,
        spectra["uncertainty"].values,
        strict=True,
    )
    kinds = [record["kind"] for record in session.records]
    torn = session.torn + sum(record.get("torn", 0) for record in session.records)
    return {
        "subject": plan.subject,
        "instrument": spectra.attrs["instrument"],
        "readings": kinds.count("reading"),
        "errors": kinds.count("error"),
        "torn_bytes": torn,
        "spectra": [
            {
                "label": str(label),
                "reflectance_median": float(np.nanmedian(value)),
                "uncertainty_median": float(np.nanmedian(u)),
            }
            for label, value, u in rows
        ],
        "scatter": derived.frames.scatter(),
        "asymmetry": {
            site: {"value": value, "uncertainty": u}
            for site, (value, u) in derived.asymmetry.items()
        },
        "notes": [*derived.notes],
    }


def fitted_lobe(derived: Derived, site: str) -> dict[str, Any]:
    """Return the lobe fitted to a site's specular part."""
    lobe = lobe_of(derived, site)
    fit = fit_lobe(
        np.deg2rad(lobe.illumination),
        lobe.specular,
        viewing=np.deg2rad(lobe.viewing),
        uncertainty=lobe.uncertainty,
        n=derived.frames.plan.n,
    )
    fit.raise_for_status()
    found = {
        name: {"value": float(value), "lower": float(low), "upper": float(high)}
        for name, value, (low, high) in zip(
            fit.parameters, fit.values, fit.interval, strict=True
        )
    }
    surface = fit.surface
    return {
        **found,
        "chi_square": fit.chi_square,
        "readings": int(lobe.specular.size),
        "surface": {
            "model": surface.name,
            "gamma": round(surface.gamma, 4),
            "n": surface.n,
            "specular_scale": round(surface.specular_scale, 4),
        },
    }


def report_lines(told: dict[str, Any]) -> list[str]:
    """Return what is told as lines of text."""
    spectra = told["spectra"]
    lines = [
        f"{told['subject']}: {told['readings']} readings by {told['instrument']}"
        + (f", {n} errors in the log" if (n := told["errors"]) else "")
    ]
    lines += table(
        "reflectance",
        [row["label"] for row in spectra],
        [
            Column("median", [f"{row['reflectance_median']:.4f}" for row in spectra]),
            Column("u", [f"{row['uncertainty_median']:.4f}" for row in spectra]),
        ],
    )
    scatter = ", ".join(f"{name} {x:.2%}" for name, x in told["scatter"].items())
    lines.append(f"scatter of repeats: {scatter}")
    lines += [
        f"asymmetry of diffuse light, {site}: {k['value']:.4f} ± {k['uncertainty']:.4f}"
        for site, k in told["asymmetry"].items()
    ]
    lobe = told.get("lobe")
    if lobe is not None:
        lines += [
            f"{name} {lobe[name]['value']:.4f}, 95 % interval "
            f"{lobe[name]['lower']:.4f} to {lobe[name]['upper']:.4f}"
            for name in ("beta", "gamma")
        ]
        lines += ["for a scene file:", "[surface]"]
        lines += [
            f'{key} = "{x}"' if isinstance(x, str) else f"{key} = {x:g}"
            for key, x in lobe["surface"].items()
        ]
    if told["torn_bytes"]:
        lines.append(f"note: {told['torn_bytes']} bytes of a torn last line are lost")
    return lines + [f"note: {note}" for note in told["notes"]]
