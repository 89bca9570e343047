"""``render``: a scene as a picture whose every pixel has a spectrum."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinviz._validate import in_range
from skinviz.errors import ArgumentError, SceneWarning
from skinviz.rendering.check import checked
from skinviz.rendering.colour import encoded
from skinviz.rendering.darkness import why_dark
from skinviz.rendering.files import write_picture
from skinviz.rendering.geometry import Geometry
from skinviz.rendering.imager import Advance, Box, Single, image_of, pixel_radiance
from skinviz.rendering.plan import Plan
from skinviz.rendering.planner import planned
from skinviz.rendering.stage import Stage, stage_of
from skinviz.scene.camera import View
from skinviz.scene.describe import describe
from skinviz.scene.scene import Scene
from skinviz.spectra.display import DisplayCounts

Array = NDArray[np.float64]

_BLOCK = 2**22  # numbers that are streamed at once


@dataclass(frozen=True, eq=False, repr=False)
class Rendering:
    """A picture of a scene: its colours, and the spectrum of any pixel on demand.

    Spectra are not kept: they are traced anew where they are asked for, from the same
    rays, so that a picture costs 14 bytes a pixel however many bands it has.

    Attributes
    ----------
    xyz : (height, width, 3) ndarray of float32
        Tristimulus values of the light from the mesh; Y = 1 is the perfect diffuser
        that faces light 1 at the mesh's centroid, times the exposure.
    covered, rays : (height, width) ndarray of uint8
        How many of a pixel's rays hit the mesh, of how many.
    notes : tuple of str
        What the scene's maker should know of it.
    """

    xyz: Single
    covered: NDArray[np.uint8]
    rays: NDArray[np.uint8]
    notes: tuple[str, ...]
    _stage: Stage

    def __repr__(self) -> str:
        """Say what it is a picture of; its arrays would fill pages."""
        width, height = self.size
        return (
            f"Rendering({width} x {height} pixels, {self.wavelengths.size} bands, "
            f"{self.plan.samples} samples a pixel)"
        )

    @property
    def scene(self) -> Scene:
        """What is shown."""
        return self._stage.scene

    @property
    def plan(self) -> Plan:
        """How it was computed."""
        return self._stage.plan

    @property
    def view(self) -> View:
        """Where points of the scene lie in the picture."""
        return self._stage.sight.view

    @property
    def size(self) -> tuple[int, int]:
        """Width and height. [pixels]"""
        return self.scene.camera.size

    @property
    def wavelengths(self) -> Array:
        """Of the spectra. [nm]"""
        return self.scene.wavelengths

    @property
    def coverage(self) -> Single:
        """The share of each pixel that shows the mesh (height, width). [1]"""
        return np.asarray(self.covered / self.rays.astype(np.float32))

    @property
    def rgb(self) -> NDArray[np.uint8]:
        """What the scene's display shows (height, width, 3), on its background."""
        return self._shown[0]

    @property
    def rgb16(self) -> NDArray[np.uint16]:
        """The same in 16 bits a channel, computed anew each time."""
        return encoded(self.scene, self.xyz, self.coverage, bits=16)[0]

    @property
    def counts(self) -> DisplayCounts:
        """How many pixels of the mesh the display cannot show."""
        return self._shown[1]

    @property
    def icc(self) -> bytes | None:
        """The ICC profile of the display; None for sRGB."""
        return self.scene.display.icc

    @cached_property
    def _shown(self) -> tuple[NDArray[np.uint8], DisplayCounts]:
        """The picture and what could not be shown."""
        return encoded(self.scene, self.xyz, self.coverage)

    def radiance(
        self,
        where: tuple[int, ...] | None = None,
        *,
        out: Single | None = None,
        advance: Advance | None = None,
    ) -> Single:
        """Return the spectral radiance of a pixel, a region or the whole picture.

        Parameters
        ----------
        where : (column, row) or (left, top, right, bottom), optional
            A pixel, or a region up to but without its right and bottom, from the
            picture's top left. [pixels]
        out : (rows, columns, bands) ndarray of float32, optional
            Where to write, C-contiguous.
        advance : callable, optional
            Told the number of pixels done.

        Returns
        -------
        radiance : (bands,) or (rows, columns, bands) ndarray of float32
            In units in which the perfect diffuser under light 1 has Y = exposure.

        Raises
        ------
        ArgumentError
            If the pixel or region is not within the picture, its spectra are more
            than the memory holds, or ``out`` is not as it must be.
        """
        left, top, right, bottom = box = _box(where, self.size)
        shape = (bottom - top, right - left, self.wavelengths.size)
        out = _target(shape) if out is None else _checked(out, shape)
        flat = out.reshape(-1, shape[2])
        pixel_radiance(self._stage, box, self.rays, flat, advance)
        return out[0, 0] if where is not None and len(where) == 2 else out

    @property
    def metadata(self) -> dict[str, Any]:
        """How the picture was made, as JSON can hold it."""
        from skinviz import __version__

        return {
            "title": "Skin in spectrally computed colour",
            "units": {
                "radiance": "the perfect diffuser facing light 1 at the mesh's "
                "centroid, lit by it alone, has Y = exposure",
                "wavelengths": "nm",
            },
            "software": f"skinviz {__version__}",
            "scene": describe(self.scene),
            "plan": dataclasses.asdict(self.plan),
            "counts": dataclasses.asdict(self.counts),
            "notes": list(self.notes),
        }

    def save(
        self, path: str | os.PathLike[str], *, advance: Advance | None = None
    ) -> Path:
        """Write the picture or its spectra, in the format that the suffix names.

        Parameters
        ----------
        path : str or path-like
            ``.png`` (8 bits) or ``.tif`` (16 bits) for colours, ``.hdr`` (ENVI) or
            ``.exr`` for the spectrum of every pixel. The scene goes into all.
        advance : callable, optional
            Told the number of pixels whose spectra are done.

        Returns
        -------
        path : Path
            The file written, whole.

        Raises
        ------
        ArgumentError
            If the suffix is none of these.
        SkinvizError
            If it cannot be written; what was there before still is.
        """
        return write_picture(path, self, advance)

    def rows(self, advance: Advance | None = None) -> Iterator[Single]:
        """Yield the spectral radiance of the picture's rows, some at a time.

        Each is (rows, width, bands) float32, top to bottom: pictures whose spectra
        are larger than the memory are written so. The memory is used again for the
        next: copy what is to be kept.
        """
        width, height = self.size
        bands = self.wavelengths.size
        step = min(max(1, _BLOCK // (width * bands)), height)
        block = np.zeros((step, width, bands), dtype=np.float32)
        for top in range(0, height, step):
            bottom = min(top + step, height)
            yield self.radiance(
                (0, top, width, bottom), out=block[: bottom - top], advance=advance
            )


def render(
    scene: Scene,
    plan: Plan | None = None,
    tolerance: float = 1.0,
    *,
    geometry: Geometry | None = None,
    advance: Advance | None = None,
) -> Rendering:
    """Trace a scene's rays and return its picture.

    Parameters
    ----------
    scene : Scene
        What is lit and seen.
    plan : Plan, optional
        How finely, as from :func:`skinviz.plan`; made for the tolerance by default.
        ``Plan()`` is the reference, which leaves nothing out.
    tolerance : float
        What the picture's colours may differ from the reference's by, where no plan
        is given; see :func:`skinviz.plan`. [ΔE00]
    geometry : Geometry, optional
        Of the scene's mesh, from :func:`geometry_of`: saves its preparation where
        one mesh is shown several times.
    advance : callable, optional
        Told the number of pixels done, as they are.

    Returns
    -------
    rendering : Rendering
        Colours at once, spectra on demand.

    Raises
    ------
    MeshError
        If the mesh is empty, has no extent or a vertex that is not finite.
    ArgumentError
        If the eye is inside the mesh, a light stands at its centroid, or the light is
        more than float32 holds.

    Warns
    -----
    SceneWarning
        If the picture is empty or black, and why; see ``Rendering.notes``.
    """
    stage = stage_of(scene, plan, geometry)
    eye = stage.sight.eye
    if eye[3] and abs(stage.geometry.winding(eye[:3])) > 0.5:
        raise ArgumentError(
            "the camera is inside the mesh; give view a larger distance, or another "
            "target"
        )
    if plan is None:
        stage = planned(stage, tolerance)
    image = image_of(stage, advance)
    if plan is None:
        stage, image = checked(stage, image)
    notes = tuple(why_dark(stage, image.xyz, image.covered))
    for note in notes:
        warnings.warn(note, SceneWarning, stacklevel=2)
    shape = scene.camera.size[::-1]
    return Rendering(
        image.xyz.reshape(*shape, 3),
        image.covered.reshape(shape),
        image.rays.reshape(shape),
        notes,
        stage,
    )


def _box(where: tuple[int, ...] | None, size: tuple[int, int]) -> Box:
    """Return left, top, right and bottom of a pixel, a region or the whole."""
    width, height = size
    if where is None:
        return 0, 0, width, height
    if np.ndim(where) != 1 or len(where) not in (2, 4):
        raise ArgumentError(
            f"radiance takes (column, row) or (left, top, right, bottom); got {where!r}"
        )
    for value in where:
        in_range(value, 0, max(size), "a pixel's column or row")
        if value != int(value):
            raise ArgumentError(
                f"columns and rows must be whole numbers; got {where!r}"
            )
    left, top, *ends = (int(value) for value in where)
    right, bottom = ends or (left + 1, top + 1)
    if not (left < right <= width and top < bottom <= height):
        raise ArgumentError(
            f"{where!r} is not within the picture of {width} x {height} pixels"
        )
    return left, top, right, bottom


def _target(shape: tuple[int, int, int]) -> Single:
    """Return memory for spectra, or say how much they want."""
    try:
        return np.zeros(shape, dtype=np.float32)
    except MemoryError as error:
        rows, columns, bands = shape
        raise ArgumentError(
            f"the radiance of {columns} x {rows} pixels in {bands} bands takes "
            f"{4 * rows * columns * bands / 2**30:.1f} GiB, more than there is; ask "
            "for a region, go through rows(), or save it"
        ) from error


def _checked(out: Single, shape: tuple[int, int, int]) -> Single:
    """Return an array that spectra can be written to, or say what is wrong with it."""
    fits = isinstance(out, np.ndarray) and out.shape == shape
    if not fits or out.dtype != np.float32 or not out.flags.c_contiguous:
        raise ArgumentError(
            f"out must be a C-contiguous float32 array of shape {shape}; got "
            f"{getattr(out, 'dtype', type(out).__name__)} {np.shape(out)}"
        )
    return out
