"""What is to be shown: a mesh, its skin and surface, lights, and a view of it."""

from skinviz.scene.hand import HandFrame, hand_frame
from skinviz.scene.scene import Camera, DirectionalLight, Scene, Skin
from skinviz.scene.scene_file import read_scene

__all__ = [
    "Camera",
    "DirectionalLight",
    "HandFrame",
    "Scene",
    "Skin",
    "hand_frame",
    "read_scene",
]
