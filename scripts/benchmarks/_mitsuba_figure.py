"""The pictures of ``against_mitsuba.py``: colours side by side, time against error."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from skinviz._files import whole_file
from skinviz.spectra.colorimetry import encode_srgb, xyz_to_linear_srgb

# Okabe and Ito's colours; markers tell the curves apart without them.
_STYLES = [("#009E73", "o", "-"), ("#D55E00", "s", "--"), ("#0072B2", "v", "-.")]


def draw_maps(ours, theirs, map_, title: str, path: Path) -> None:
    """Draw both pictures and the map of ΔE00 between them, cut to the hand."""
    rows, columns = (np.flatnonzero(np.isfinite(map_).any(axis=k)) for k in (1, 0))
    cut = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    panels = figure.subplots(1, 3)
    for panel, xyz, name in (
        (panels[0], ours, "skinviz"),
        (panels[1], theirs, "Mitsuba 3"),
    ):
        panel.imshow(encode_srgb(xyz_to_linear_srgb(xyz[cut])))
        panel.set_title(name)
    top = max(1.0, float(np.nanpercentile(map_, 99.9)))
    image = panels[2].imshow(map_[cut], cmap="viridis", vmin=0, vmax=top)
    panels[2].set_title("difference")
    figure.colorbar(image, ax=panels[2], label="ΔE00", extend="max", shrink=0.8)
    for panel in panels:
        panel.set_axis_off()
    figure.suptitle(title)
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=100)


def draw_race(curves: dict, path: Path) -> None:
    """Draw the mean error of each curve's points over their time."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    panel = figure.subplots()
    for (name, points), (colour, marker, dash) in zip(
        curves.items(), _STYLES, strict=True
    ):
        times = [point.seconds for point in points]
        errors = [point.error.mean for point in points]
        panel.loglog(times, errors, color=colour, marker=marker, ls=dash, label=name)
        for point in points:
            panel.annotate(
                str(point.samples), (point.seconds, point.error.mean),
                xytext=(4, 5), textcoords="offset points", fontsize=8, color=colour,
            )  # fmt: skip
    panel.set(xlabel="time of a picture [s]", ylabel="mean ΔE00 to the reference")
    panel.set_title("Numbers: samples a pixel", fontsize=10)
    panel.grid(alpha=0.25, which="both", linewidth=0.5)
    panel.spines[["top", "right"]].set_visible(False)
    panel.legend(frameon=False)
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=110)
