"""Pictures with a known spectrum at every pixel, for the tests of their files."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

NM = [400.0, 512.5, 632.8, 700.0]
METADATA = {
    "title": "Linke Hand, 60°/60°",
    "units": {"radiance": "1 / white under light 1 {per band}", "length": "mm"},
    "scene": {
        "mesh": "hände/手.ply",
        "camera": {"size": [7, 5], "angles": "60/60"},
        "weights": [0.02, 1e-300, -0.0, 5e300],
        "masking": None,
        "shadows": True,
    },
    "versions": {"skinviz": "9.9.9"},
    "attribution": "MakeHuman, CC0; {braces}, 100 % \"quoted\" 'text' \\ = ;\nline 2",
}


@dataclass(frozen=True)
class MadePicture:
    """A picture of random radiance; ``at_once`` rows come in a block."""

    size: tuple = (7, 5)
    wavelengths: np.ndarray = field(default_factory=lambda: np.array(NM))
    metadata: dict = field(default_factory=lambda: METADATA)
    icc: bytes | None = None
    at_once: int = 2

    @cached_property
    def radiance(self):
        shape = (self.size[1], self.size[0], len(self.wavelengths))
        return self._random(1).random(shape, dtype=np.float32)

    @cached_property
    def rgb(self):
        return self._random(2).integers(0, 256, self._colours, dtype=np.uint8)

    @cached_property
    def rgb16(self):
        return self._random(3).integers(0, 65536, self._colours, dtype=np.uint16)

    @cached_property
    def xyz(self):
        return self._random(4).random(self._colours, dtype=np.float32)

    def rows(self, advance=None):
        for top in range(0, self.size[1], self.at_once):
            block = self.radiance[top : top + self.at_once]
            yield block
            if advance is not None:
                advance(len(block))

    @property
    def _colours(self):
        return (self.size[1], self.size[0], 3)

    def _random(self, seed):
        return np.random.default_rng(seed)
