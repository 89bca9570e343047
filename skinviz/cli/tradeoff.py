"""``skinviz tradeoff``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skinviz.cli.arguments import Whole
from skinviz.cli.output import (
    progress_bar,
    require_folder,
    say,
    say_files,
    say_json,
    versions,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from skinviz.rendering.tradeoff import Trade
    from skinviz.scene.scene import Scene

SETTINGS = (
    *("samples", "refine", "shadows", "bounce_rays", "spectrum", "reflectance"),
    *("specular", "shading", "basis", "arithmetic"),
)
"""What of a plan has a column."""


def tradeoff(
    scene: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    size: Whole | None = None,
    json: bool = False,
) -> None:
    """Measure what speed costs in accuracy on a scene, and what plans make of it.

    Each knob of the plan, fewer rays, the plain way, plans for several tolerances and
    combinations are timed and compared with the reference; tradeoff.csv has all of
    them, tradeoff.png and .svg the picture. Let nothing else run meanwhile.

    Example: skinviz tradeoff scene.toml -o trade --size 512

    Parameters
    ----------
    scene
        Scene file (TOML).
    out
        Folder to write into; made if it does not exist.
    size
        Longer side of the picture in pixels, instead of the scene's size.
    json
        Print what was measured as JSON.
    """
    from skinviz.cli.render import sized
    from skinviz.rendering.geometry import geometry_of
    from skinviz.rendering.tradeoff import tradeoff as measured
    from skinviz.rendering.ways import ways
    from skinviz.scene.scene_file import read_scene

    require_folder(out)
    with progress_bar(4) as begin:
        begin("read scene")
        described = sized(read_scene(scene), size)
        geometry = geometry_of(described.mesh)
        begin("plan")
        tried = ways(described, geometry=geometry)
        begin("time and compare")
        advance = begin.counting(len(tried))
        trades = measured(described, tried, geometry=geometry, advance=advance)
        begin("write")
        head = _head(scene.name, described)
        files = write_tradeoff(out, trades, head)
    if json:
        say_json({"files": [str(f) for f in files], **head, "ways": _rows(trades)})
        return
    _say_plans(trades)
    say_files(files)


def write_tradeoff(
    folder: Path, trades: Sequence[Trade], head: dict[str, str]
) -> list[Path]:
    """Write the table and both figures into a folder: all of them or none.

    ``head`` says what was measured, a line each.
    """
    from skinviz._files import whole_files
    from skinviz.view.figures import save_figure
    from skinviz.view.tradeoff_figure import tradeoff_figure

    told = dict(head)
    title = f"Speed against accuracy: {told.pop('scene')}"
    caption = ".  ".join(f"{name}: {value}" for name, value in told.items())
    figure = tradeoff_figure(trades, title, f"{caption}.")
    files = [folder / f"tradeoff.{suffix}" for suffix in ("csv", "png", "svg")]
    with whole_files(*files) as (table, *figures):
        table.write_text(as_csv(trades, head), encoding="utf-8")
        for partial in figures:
            save_figure(figure, partial)
    return files


def as_csv(trades: Sequence[Trade], head: dict[str, str]) -> str:
    """Return what was measured as CSV, with what it was measured on before it."""
    import csv
    import io

    text = io.StringIO()
    text.writelines(f"# {name}: {value}\n" for name, value in head.items())
    rows = _rows(trades)
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _rows(trades: Sequence[Trade]) -> list[dict[str, Any]]:
    """Return one row a way."""
    return [_row(trade) for trade in trades]


def _row(trade: Trade) -> dict[str, Any]:
    """Return what one way is, costs and changes; None where nothing was measured."""
    way, off = trade.way, trade.difference
    settings = {name: getattr(way.plan, name) for name in SETTINGS}
    return {
        "group": way.group,
        "name": way.name,
        "tolerance": way.tolerance,
        **settings,
        "ms": _rounded(trade.ms, 2),
        "planning_ms": _rounded(way.planning, 2),
        "delta_e_99_filled": None if off is None else _rounded(off.filled, 5),
        "delta_e_max_filled": None if off is None else _rounded(off.most_filled, 5),
        "delta_e_99_edge": None if off is None else _rounded(off.edge, 5),
        "delta_e_max_edge": None if off is None else _rounded(off.most_edge, 5),
        "spectral_rmse": _rounded(trade.spectral_rmse, 8),
        "on_front": trade.on_front,
        "edges_kept": trade.edges_kept,
        "kept": trade.kept,
        "note": " ".join(trade.note.split()),
    }


def _rounded(value: float | None, digits: int) -> float | None:
    """Return a number with as many digits as matter."""
    return None if value is None else round(value, digits)


def _head(name: str, scene: Scene) -> dict[str, str]:
    """Return what was measured, and on which machine."""
    width, height = scene.camera.size
    lamps = ", ".join(light.spectrum.name for light in scene.lights)
    numbers = versions()
    told = ", ".join(f"{key} {numbers[key]}" for key in ("skinviz", "python", "numpy"))
    return {
        "scene": f"{name}, {width} × {height} pixels, {scene.wavelengths.size} bands, "
        f"{scene.mesh.n_cells} triangles, light {lamps}, interreflection "
        f"{scene.interreflection}",
        "machine": machine(),
        "versions": told,
        "times": "shortest of three, of fewer where these take over two seconds; "
        "planning apart",
    }


def machine() -> str:
    """Return on what this runs, as far as the system tells."""
    import platform

    from skinviz._threads import processors

    name = platform.processor() or platform.machine()
    told = Path("/proc/cpuinfo")
    if told.exists():
        lines = told.read_text(encoding="utf-8", errors="replace").splitlines()
        models = [line.split(":", 1)[1] for line in lines if line[:10] == "model name"]
        name = models[0].strip() if models else name
    return f"{name}, {processors()} processors, {platform.system()}"


def _say_plans(trades: Sequence[Trade]) -> None:
    """Say what plans cost and keep, a line each, and what cannot be had."""
    from skinviz.rendering.ways import PLAIN_WAY, REFERENCE, TOLERANCE

    labels = {REFERENCE: "reference", PLAIN_WAY: "the plain way"}
    say(f"{'':<20}{'ms':>8}{'planning':>10}{'ΔE00 99 %':>11}{'max':>8}{'edges':>8}")
    for trade in trades:
        off, way = trade.difference, trade.way
        if off is None:
            say(f"note: {way.name} cannot be had: {trade.note}")
            continue
        if way.group == REFERENCE and trade.note:
            say(f"note: spectra cannot be had: {trade.note}")
        if way.group in labels or way.group == TOLERANCE:
            planning = f"{way.planning:.0f}" if way.group == TOLERANCE else "-"
            label = labels.get(way.group, f"plan for {way.name}")
            say(
                f"{label:<20}{trade.ms:>8.0f}{planning:>10}{off.filled:>11.3f}"
                f"{off.most_filled:>8.2f}{off.edge:>8.2f}"
                + ("  NOT KEPT" if trade.kept is False else "")
            )
