"""The figure of docs/transport.md, from the results of ``transport.py``."""

from pathlib import Path

import numpy as np
from _transport_spectra import DERMIS, MELANIN, WAVELENGTHS, colour_difference
from matplotlib.figure import Figure

from skinviz._files import whole_file
from skinviz.skin.interface import interface

# Okabe and Ito's colours; markers and dashes tell the rules apart without them.
STYLES = {
    "gate": (r"Gate: ¾ $\mu_s'$", "#0072B2", "o", "-"),
    "star": (r"Star: ¾ $\mu_s'$ − ¼ $\mu_a$", "#D55E00", "v", "--"),
    "klier": ("Klier: asymptotic", "#009E73", "s", "-."),
    "meador_weaver": ("Meador & Weaver: 1/√3", "#CC79A7", "^", (0, (5, 1))),
    "toon": ("Toon: hemispheric", "#E69F00", "D", ":"),
}
SHOWN_MELANIN = (0.01, 0.12, 0.43)


def draw(results, fitted, path: Path) -> None:
    """Draw the four panels and write the PNG whole or not at all."""
    figure = Figure(figsize=(10.6, 8.2), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1)
    axes = figure.subplots(2, 2)
    _spectra(axes[0, 0], results)
    _by_wavelength(axes[0, 1], results)
    _by_melanin(axes[1, 0], results)
    _absorbed(axes[1, 1], results, fitted)
    for letter, panel in zip("abcd", axes.flat, strict=True):
        panel.set_title(f"({letter})  {panel.get_title()}", loc="left", fontsize=11)
        panel.set_title("")
        panel.tick_params(labelsize=10)
        panel.grid(alpha=0.25, linewidth=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=120)


def _spectra(panel, results) -> None:
    """Draw R_b of three skins by transport and by Kubelka–Munk."""
    dermis = int(np.flatnonzero((DERMIS == (0.01, 0.6)).all(axis=1))[0])
    for fraction in SHOWN_MELANIN:
        m = int(np.flatnonzero(fraction == MELANIN)[0])
        for spectra, colour, dash, label in (
            (results.transport["body"], "black", "-", "transport"),
            (results.body["gate"], STYLES["gate"][1], "--", "Kubelka–Munk, Gate"),
        ):
            line = panel.plot(
                WAVELENGTHS, spectra[0, m, dermis], color=colour, ls=dash, lw=1.8
            )[0]
            if fraction == SHOWN_MELANIN[0]:
                line.set_label(label)
        panel.annotate(
            f"{fraction:.0%}", (700, results.transport["body"][0, m, dermis, -1]),
            xytext=(5, 0), textcoords="offset points", va="center", fontsize=10,
        )  # fmt: skip
    panel.set(
        xlabel="wavelength [nm]",
        ylabel=r"diffuse reflectance $R_b$ [1]",
        xlim=(400, 722),
        ylim=(0, 1),
        title="cheek, 1 % blood; melanin as marked",
    )
    panel.legend(frameon=False, fontsize=10, loc="upper left")


def _by_wavelength(panel, results) -> None:
    """Draw the mean ΔR over all skins that a rule covers."""
    truth = results.transport["body"]
    for rule, body in results.body.items():
        label, colour, marker, dash = STYLES[rule]
        known = np.isfinite(body).all(axis=-1)
        panel.plot(
            WAVELENGTHS, (body - truth)[known].mean(axis=0),
            color=colour, ls=dash, marker=marker, ms=4.5, markevery=3, label=label,
        )  # fmt: skip
    panel.axhline(0, color="black", lw=0.8)
    panel.set(
        xlabel="wavelength [nm]",
        ylabel=r"mean $\Delta R_b$, Kubelka–Munk − transport [1]",
        xlim=(400, 700),
        title="no surface, diffuse light",
    )
    panel.set_ylim(top=0.085)
    panel.legend(frameon=False, fontsize=9, loc="upper right", ncols=2)


def _mean(delta_e):
    """Return the mean over sites and blood (M,), NaN where a skin is not covered."""
    return delta_e.mean(axis=(0, 2))


def _by_melanin(panel, results) -> None:
    """Draw the mean ΔE00 of each rule along melanin."""
    for rule, body in results.body.items():
        label, colour, marker, dash = STYLES[rule]
        mean = _mean(colour_difference(body, results.transport["body"]))
        panel.plot(
            100 * MELANIN, mean, color=colour, ls=dash, marker=marker, ms=5, label=label
        )
    _melanin_axis(panel, "no surface, diffuse light")


def _absorbed(panel, results, fitted) -> None:
    """Draw what the interface costs, and what is left after a fit."""
    sphere = results.transport["sphere"]
    measured = interface("included").measured
    body = results.transport["body"]
    for values, label, colour, marker, dash in (
        (colour_difference(measured(results.body["gate"]), sphere),
         "sphere, Gate, same weights", "#0072B2", "o", "-"),
        (colour_difference(measured(body), sphere),
         "sphere, interface form alone", "black", "s", "--"),
        (fitted["sphere, gate"], "sphere, Gate, after a fit", "#D55E00", "^", "-"),
        (fitted["body, gate"], "no surface, Gate, after a fit", "#009E73", "v", "-."),
    ):  # fmt: skip
        panel.plot(
            100 * MELANIN, _mean(values), color=colour, ls=dash, marker=marker, ms=5,
            label=label,
        )  # fmt: skip
    _melanin_axis(panel, "n = 1.4 in a sphere (8°/diffuse), and after a fit")


def _melanin_axis(panel, title: str) -> None:
    """Give a panel of ΔE00 along melanin its axes."""
    panel.set_xscale("log")
    panel.set_xticks(100 * MELANIN, [f"{m:.0f}" for m in 100 * MELANIN])
    panel.minorticks_off()
    panel.set(
        xlabel="melanin, fraction of the epidermis [%]",
        ylabel=r"mean $\Delta E_{00}$, D65",
        ylim=(0, 10.5),
        title=title,
    )
    panel.legend(frameon=False, fontsize=9.5, loc="upper left")
