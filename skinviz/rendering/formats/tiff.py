"""TIFF: 16 bits a channel, deflated, with its ICC profile.

References
----------
.. [1] Adobe, TIFF Revision 6.0 (1992); Adobe Photoshop TIFF Technical Notes (2002).
.. [2] ICC.1:2022, Image technology colour management, section 7.2.
"""

from __future__ import annotations

import contextlib
import logging
import struct
from collections.abc import Iterator
from pathlib import Path

from skinviz._files import whole_file
from skinviz.errors import DataError
from skinviz.rendering.formats.metadata import SOFTWARE, as_json
from skinviz.rendering.formats.picture import Advance, SpectralPicture

_CLASSIC = 2**32 - 2**25  # bytes; beyond, offsets of 32 bits may not reach
_EFFORT = 3  # of deflating, 0 to 9: more takes longer and hardly saves
_DESCRIPTION = 270  # the tag ImageDescription
_DATE = slice(24, 36)  # of an ICC profile's header: six big-endian numbers
_FIXED_DATE = struct.pack(">6H", 2000, 1, 1, 0, 0, 0)


def write(file: Path, picture: SpectralPicture, advance: Advance | None = None) -> None:
    """Write the colours in 16 bits; BigTIFF only where the size asks for it."""
    import tifffile

    told = as_json(picture.metadata, file)
    with whole_file(file) as partial:
        rgb = picture.rgb16
        tifffile.imwrite(
            partial,
            rgb,
            photometric="rgb",
            compression="zlib",
            compressionargs={"level": _EFFORT},
            predictor=True,
            bigtiff=rgb.nbytes > _CLASSIC,
            iccprofile=srgb_profile() if picture.icc is None else picture.icc,
            description=told,
            software=SOFTWARE,
            metadata=None,  # of tifffile's own, which would be put in front
        )
    if advance is not None:
        advance(picture.size[1])


def read_metadata(file: Path) -> str | None:
    """Return how a picture was made; None if the file does not say it."""
    import tifffile

    try:
        with _silence(), tifffile.TiffFile(file) as whole:
            tag = whole.pages.first.tags.get(_DESCRIPTION)
            text = None if tag is None else tag.value
    except Exception as error:  # whatever a broken file makes tifffile raise
        raise DataError(f"{file}: not a whole TIFF file: {error}") from error
    return text if isinstance(text, str) else None


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep tifffile from printing every fault of a broken file."""
    logger = logging.getLogger("tifffile")
    before = logger.disabled
    logger.disabled = True
    try:
        yield
    finally:
        logger.disabled = before


def srgb_profile() -> bytes:
    """Return the ICC profile of sRGB, the same bytes at any time."""
    from PIL import ImageCms

    profile = bytearray(
        ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    )
    profile[_DATE] = _FIXED_DATE
    return bytes(profile)
