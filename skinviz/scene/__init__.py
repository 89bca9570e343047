"""What is to be shown: a mesh, its skin and surface, lights, and a view of it."""

from skinviz.scene.camera import Camera
from skinviz.scene.hand import Hand, HandFrame, hand_frame, measure_hand
from skinviz.scene.lights import DirectionalLight, PointLight
from skinviz.scene.scene import Scene, Skin
from skinviz.scene.scene_file import read_scene

__all__ = [
    "Camera",
    "DirectionalLight",
    "Hand",
    "HandFrame",
    "PointLight",
    "Scene",
    "Skin",
    "hand_frame",
    "measure_hand",
    "read_scene",
]
