"""Draw the coefficient tables, for ``docs/coefficients.md``."""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, ScalarFormatter

from skinviz._files import whole_file
from skinviz.skin.coefficients import Coefficients, load_coefficients
from skinviz.skin.formulas import EffectiveNumbers, effective_coefficients

# Okabe & Ito's colours, which the colour-blind tell apart; labels stand at the curves.
CURVES = (
    {
        "melanin": ("$K_m$ melanin", "#000000"),
        "oxyhaemoglobin": ("$K_h$ oxygenated blood", "#D55E00"),
        "deoxyhaemoglobin": ("$K_{dh}$ deoxygenated\nblood", "#0072B2"),
    },
    {
        "epidermis": ("$S_e$ epidermis", "#009E73"),
        "dermis": ("$S_d$ dermis", "#CC79A7"),
    },
)
STYLES = {
    "effective, as shipped": ("-", 2.0),
    "textbook": ("--", 1.4),
    "retuned, not adopted": (":", 1.8),
}


def draw(path: Path, retuned: EffectiveNumbers) -> None:
    """Write absorption and scattering of both shipped tables and of a retuned one."""
    tables = (
        load_coefficients("effective"),
        load_coefficients("textbook"),
        effective_coefficients(retuned, "retuned"),
    )
    figure = Figure(figsize=(9.6, 4.4), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 2)
    titles = ("absorption of the pigments", "back-scattering of the tissues")
    for axes, curves, title, symbol in zip(panels, CURVES, titles, "KS", strict=True):
        for table, (dashes, width) in zip(tables, STYLES.values(), strict=True):
            _curves(axes, table, curves, dashes, width)
        axes.set_title(title, fontsize=10)
        axes.set_ylabel(f"{symbol} [mm$^{{-1}}$]")
        _axes(axes)
    _words(panels)
    with whole_file(path) as partial:
        figure.savefig(partial)


def _curves(
    axes: Axes, table: Coefficients, curves: dict, dashes: str, width: float
) -> None:
    """Draw a table's curves; blood is the same in all and drawn once."""
    for name, (_, colour) in curves.items():
        if name.endswith("haemoglobin") and table.name != "effective":
            continue
        axes.plot(
            *(table.wavelengths, getattr(table, name), dashes), lw=width, color=colour
        )


def _axes(axes: Axes) -> None:
    """Make both axes logarithmic, so that power laws are straight."""
    axes.set(xscale="log", yscale="log", xlim=(380, 780), xlabel="wavelength [nm]")
    axes.set_xticks([400, 450, 500, 550, 600, 650, 700, 750])
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", color="0.9", lw=0.6)


def _words(panels: tuple[Axes, Axes]) -> None:
    """Name the curves beside them and the tables in a legend."""
    left, right = panels
    places = (
        ((560, 190, "left"), (605, 1.2, "right"), (620, 11, "left")),
        ((385, 2.15, "left"), (475, 8.6, "left")),
    )
    for axes, curves, spots in zip(panels, CURVES, places, strict=True):
        for (text, colour), (x, y, side) in zip(curves.values(), spots, strict=True):
            axes.text(x, y, text, color=colour, fontsize=9, ha=side)
    right.set_yticks([1, 2, 5, 10])
    right.yaxis.set_major_formatter(ScalarFormatter())
    right.yaxis.set_minor_formatter(NullFormatter())
    handles = [
        Line2D([], [], color="0.25", ls=dashes, lw=width, label=name)
        for name, (dashes, width) in STYLES.items()
    ]
    right.legend(handles=handles, frameon=False, fontsize=8.5, loc="upper right")
    left.set_ylim(0.2, 500)
