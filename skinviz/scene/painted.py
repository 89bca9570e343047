"""Pigment maps that were painted: on a mesh's vertices, or in an image."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinviz._files import existing_file
from skinviz._validate import as_numbers, one_of
from skinviz.errors import ArgumentError, DataError, MeshError
from skinviz.scan.formats import read_mesh

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

PIGMENTS_ARRAY = "pigments"
"""Point data in which a mesh carries parameters of skin (n, p)."""

_COORDINATES = ("Texture Coordinates", "TCoords", "TEXCOORD_0", "uv")
_PNG_DEPTH = 24  # the byte that holds it
_SAME = 1e-5  # of the mesh's extent, by which its points may differ in a painted file


def painted_vertices(mesh: pyvista.PolyData, path: str | os.PathLike[str]) -> Array:
    """Return the parameters that a mesh file carries at its vertices.

    Parameters
    ----------
    mesh : pyvista.PolyData
        For which they are meant. [mm]
    path : str or path-like
        A ``.vtp`` file of the same vertices in the same order, with point data
        ``pigments`` (n, p), as ``skinviz render --mesh`` writes it.

    Returns
    -------
    values : (n, p) ndarray

    Raises
    ------
    MeshError
        If the file cannot be read, has other vertices or no such data.
    """
    painted = read_mesh(path)
    if PIGMENTS_ARRAY not in painted.point_data:
        has = ", ".join(painted.point_data.keys()) or "none"
        raise MeshError(
            f"{path} has no point data {PIGMENTS_ARRAY!r}; it has {has}. Write it as "
            ".vtp with the parameters of the skin as (n, p) numbers"
        )
    own, other = np.asarray(mesh.points), np.asarray(painted.points)
    if own.shape != other.shape:
        raise MeshError(
            f"{path} has {len(other)} vertices, the mesh {len(own)}; paint the mesh "
            "itself"
        )
    apart = float(np.abs(own - other).max())
    if apart > _SAME * float(np.ptp(own, axis=0).max()):
        raise MeshError(
            f"{path}: its vertices are up to {apart:.3g} mm from the mesh's; paint the "
            "mesh itself, and keep the order of its vertices"
        )
    values = np.asarray(painted.point_data[PIGMENTS_ARRAY], dtype=np.float64)
    return values.reshape(len(other), -1)


def painted_image(
    mesh: pyvista.PolyData, path: str | os.PathLike[str], at_one: ArrayLike
) -> Array:
    """Return the parameters that an image paints on a mesh.

    Parameters
    ----------
    mesh : pyvista.PolyData
        With texture coordinates: u to the right and v up, 0 to 1 over the image.
    path : str or path-like
        ``.png`` of 8 bits or ``.tif`` of 8 or 16, whose largest number is 1.0, or
        ``.tif`` or ``.exr`` of floats; its first p channels are the parameters.
    at_one : (p,) array_like
        The parameters that 1.0 in each channel stands for.

    Returns
    -------
    values : (n, p) ndarray
        Interpolated between the middles of pixels. What an image encodes for eyes is
        not undone: its numbers are taken as they are.

    Raises
    ------
    MeshError
        If the mesh has no texture coordinates, or some outside 0 to 1.
    DataError
        If the image cannot be read, has too few channels or a number that is not
        finite.
    """
    from scipy.ndimage import map_coordinates

    scale = as_numbers(at_one, "weights at 1.0")
    if scale.ndim != 1 or not np.isfinite(scale).all():
        raise ArgumentError(f"weights at 1.0 must be finite numbers; got {at_one!r}")
    places = _coordinates(mesh)
    image = _read_image(existing_file(path, DataError))
    if image.shape[2] < scale.size:
        raise DataError(
            f"{path} has {image.shape[2]} channels; {scale.size} are needed, one for "
            "each parameter of the skin"
        )
    height, width = image.shape[:2]
    rows = (1 - places[:, 1]) * height - 0.5
    columns = places[:, 0] * width - 0.5
    channels = [
        map_coordinates(image[..., k], [rows, columns], order=1, mode="nearest")
        for k in range(scale.size)
    ]
    return np.stack(channels, axis=1) * scale


def _coordinates(mesh: pyvista.PolyData) -> Array:
    """Return a mesh's texture coordinates (n, 2)."""
    found = mesh.active_texture_coordinates
    named = [name for name in _COORDINATES if name in mesh.point_data]
    if found is None and named:
        found = mesh.point_data[named[0]]
    if found is None:
        raise MeshError(
            "the mesh has no texture coordinates for an image; of the formats read "
            f".vtp keeps them, as point data {_COORDINATES[0]!r}"
        )
    places = np.asarray(found, dtype=np.float64)[:, :2]
    if not ((places >= 0) & (places <= 1)).all():
        raise MeshError(
            f"texture coordinates must be within 0 and 1; got {places.min():.4g} to "
            f"{places.max():.4g}"
        )
    return places


def _read_image(file: Path) -> Array:
    """Return an image (height, width, channels), whole numbers as shares of 1."""
    suffix = one_of(file.suffix.lower(), _READERS, "image suffix")
    try:
        image = np.asarray(_READERS[suffix](file))
    except Exception as error:
        raise DataError(f"{file}: no whole {suffix} image: {error}") from error
    if image.ndim == 2:
        image = image[..., None]
    if image.ndim != 3 or image.dtype.kind not in "uf" or image.size == 0:
        raise DataError(
            f"{file}: an image of {image.dtype} numbers of shape {image.shape}; it "
            "must be (height, width, channels), unsigned whole numbers or floats"
        )
    most = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1
    numbers = image.astype(np.float64) / most
    if not np.isfinite(numbers).all():
        raise DataError(f"{file}: a pixel is not finite; mend the image")
    return numbers


def _read_png(file: Path) -> NDArray[Any]:
    """Return a PNG's numbers; of more than 8 bits Pillow keeps 8, so no such."""
    from PIL import Image

    with Image.open(file) as image:
        image.load()
        content = file.read_bytes()
        if b"IEND" not in content[-16:]:  # Pillow fills in what is lacking
            raise ValueError("it is cut short")
        if image.mode not in ("L", "LA", "RGB", "RGBA") or content[_PNG_DEPTH] != 8:
            raise ValueError("not of 8 bits a channel; save it as .tif")
        return np.asarray(image)


def _read_tiff(file: Path) -> NDArray[Any]:
    """Return a TIFF's numbers."""
    import tifffile

    image = np.asarray(tifffile.imread(file))
    if image.size == 0:  # what is cut short in its header has no pages
        raise ValueError("it has no pixels")
    return image


def _read_exr(file: Path) -> NDArray[Any]:
    """Return the red, green and blue of an EXR file."""
    import OpenEXR

    with OpenEXR.File(str(file), separate_channels=True) as image:
        channels = image.channels()
        lacking = {"R", "G", "B"} - channels.keys()
        if lacking:
            raise ValueError(f"it has no channel {', '.join(sorted(lacking))}")
        return np.stack([channels[name].pixels for name in "RGB"], axis=-1)


_READERS = {
    ".png": _read_png,
    ".tif": _read_tiff,
    ".tiff": _read_tiff,
    ".exr": _read_exr,
}
