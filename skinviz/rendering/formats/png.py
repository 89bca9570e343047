"""PNG: 8 bits a channel, with the colour space and how the picture was made.

References
----------
.. [1] W3C, Portable Network Graphics Specification, 3rd edition (2025), section 11.3.
"""

from __future__ import annotations

import struct
from pathlib import Path

from skinviz._files import whole_file
from skinviz.errors import DataError
from skinviz.rendering.formats.metadata import KEY, SOFTWARE, as_json, title
from skinviz.rendering.formats.picture import Advance, SpectralPicture

_PERCEPTUAL = b"\x00"  # the rendering intent of chunk sRGB
_EFFORT = 4  # of deflating, 0 to 9: 6 takes three times as long for 6 % less
_GAMMA = struct.pack(">I", 45455)  # what [1] has readers without sRGB use: 1 / 2.2


def write(file: Path, picture: SpectralPicture, advance: Advance | None = None) -> None:
    """Write the colours; sRGB by the chunk of that name, else the ICC profile."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    marks = PngInfo()
    if picture.icc is None:
        marks.add(b"sRGB", _PERCEPTUAL)
        marks.add(b"gAMA", _GAMMA)
    marks.add_itxt("Title", title(picture.metadata))
    marks.add_itxt("Software", SOFTWARE)
    marks.add_itxt(KEY, as_json(picture.metadata, file))
    with whole_file(file) as partial:
        Image.fromarray(picture.rgb).save(
            partial,
            format="PNG",
            pnginfo=marks,
            icc_profile=picture.icc,
            compress_level=_EFFORT,
        )
    if advance is not None:
        advance(picture.size[1])


def read_metadata(file: Path) -> str | None:
    """Return how a picture was made; None if the file does not say it."""
    from PIL.PngImagePlugin import PngImageFile

    try:
        # Not Image.open, which warns of large pictures: no pixel is read here.
        with PngImageFile(file) as image:
            text = image.info.get(KEY)
    except Exception as error:  # whatever a broken file makes Pillow raise
        raise DataError(f"{file}: not a whole PNG file: {error}") from error
    return None if text is None else str(text)
