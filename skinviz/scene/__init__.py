"""What is to be shown: a mesh, its skin and surface, lights, and a view of it."""

from skinviz.scene.camera import Camera
from skinviz.scene.hand import Hand, HandFrame, hand_frame, measure_hand
from skinviz.scene.landmarks import landmarks
from skinviz.scene.lights import DirectionalLight, PointLight
from skinviz.scene.painted import painted_image, painted_vertices
from skinviz.scene.pigment_map import pigment_map
from skinviz.scene.relief import Relief
from skinviz.scene.scene import Scene, Skin
from skinviz.scene.scene_file import read_scene
from skinviz.scene.texture import SkinTexture, textured

__all__ = [
    "Camera",
    "DirectionalLight",
    "Hand",
    "HandFrame",
    "PointLight",
    "Relief",
    "Scene",
    "Skin",
    "SkinTexture",
    "hand_frame",
    "landmarks",
    "measure_hand",
    "painted_image",
    "painted_vertices",
    "pigment_map",
    "read_scene",
    "textured",
]
