"""Draw the picture of docs/maps.md: ``python scripts/maps_picture.py -o maps.png``.

The example scenes side by side: mapped skin with texture from its back, at a grazing
light and from its palm, then sunburn, inflammation and cyanosis.
"""

import argparse
from pathlib import Path

import numpy as np

from skinviz import Camera, DirectionalLight, Scene, hand_frame, read_scene, render

EXAMPLES = Path(__file__).parents[1] / "docs/examples"
SIZE = (252, 336)


def main() -> None:
    """Draw and write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, required=True)
    from PIL import Image

    mapped, *others = (
        read_scene(EXAMPLES / f"{name}.toml")
        for name in ("mapped", "sunburn", "inflammation", "cyanosis")
    )
    frame = hand_frame(mapped.mesh)
    grazing = frame.direction(np.deg2rad(60))
    scenes = [
        seen(mapped, frame.back, frame.back),
        seen(mapped, grazing, frame.back),
        seen(mapped, -frame.back, -frame.back),
        *(seen(scene, frame.back, frame.back) for scene in others),
    ]
    pictures = [render(scene, tolerance=0.5).rgb for scene in scenes]
    picture = Image.fromarray(np.concatenate(pictures, axis=1))
    picture.save(parser.parse_args().out, optimize=True)


def seen(scene: Scene, light: np.ndarray, view: np.ndarray) -> Scene:
    """Return a scene lit and seen from two directions."""
    camera = Camera(view, scene.camera.up, SIZE)
    return scene.replace(lights=(DirectionalLight(light, "D65"),), camera=camera)


if __name__ == "__main__":
    main()
