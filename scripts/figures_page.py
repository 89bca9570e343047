"""The gallery in the docs: ``python scripts/figures_page.py``.

Writes ``docs/figures.md``, every figure with its command and caption, and small
pictures of some into ``docs/images``. Run it again when a figure has changed; another
folder than ``docs`` may be named.
"""

import io
import sys
import textwrap
from pathlib import Path

from PIL import Image

from skinviz import figure
from skinviz._files import whole_file
from skinviz.view.gallery.catalogue import NAMES, GalleryFigure

DOCS = Path(__file__).parents[1] / "docs"
DOTS = 100  # per inch
LARGEST = 150_000  # bytes of a PNG with all its colours
SHOWN = (
    *("1a", "1b", "5", "7", "8", "9", "10"),
    *("uncertainty", "population", "metamerism", "metameric-lights"),
)
HEAD = Path(__file__).with_name("figures_page.md")


def small(own: GalleryFigure) -> str:
    """Return the name of a figure's small picture; photographs are no plots."""
    hands = own.recipe.suffixes == (".png",)
    return f"{own.recipe.stem}{'.jpg' if hands else '.png'}"


def picture(own: GalleryFigure, folder: Path) -> None:
    """Write a small picture: of hands as JPEG, of a plot as PNG."""
    memory = io.BytesIO()
    own.draw().savefig(memory, format="png", dpi=DOTS)
    image = Image.open(memory).convert("RGB")
    plot = small(own).endswith(".png")
    if plot and memory.tell() > LARGEST:  # clouds of points: 256 colours are enough
        image = image.quantize(256, dither=Image.Dither.NONE)
    with whole_file(folder / small(own)) as partial:
        if plot:
            image.save(partial, optimize=True)
        else:
            image.save(partial, quality=88, subsampling=0, optimize=True)


def section(own: GalleryFigure) -> str:
    """Return what the page says of a figure."""
    name, title = own.recipe.name, own.recipe.title
    shown = f"![{title}](images/{small(own)})"
    parts = [
        f"## {title}",
        f"```\nskinviz figure {name} --out figures\n```",
        *([shown] if name in SHOWN else []),
        *(textwrap.fill(part, 100) for part in own.material.caption.split("\n\n")),
        textwrap.fill(f"*{own.recipe.credit}*", 100),
    ]
    return "\n\n".join(parts) + "\n"


def main(docs: Path = DOCS) -> None:
    """Write the page and its pictures."""
    sections = [HEAD.read_text("utf-8")]
    for name in NAMES:
        own = figure(name, dots=DOTS)
        sections.append(section(own))
        if name in SHOWN:
            picture(own, docs / "images")
        print(name)
    with whole_file(docs / "figures.md") as partial:
        partial.write_text("\n".join(sections), encoding="utf-8")
    print(docs / "figures.md")


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit("usage: figures_page.py [FOLDER]")
    main(*(Path(word) for word in sys.argv[1:]))
