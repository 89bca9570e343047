"""What both programs show: the shipped hand, one person's skin, a far light."""

import numpy as np
from _mitsuba_scene import Material, Setting

from skinviz.rendering.geometry import Geometry
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import TRUE_SHAPE, shipped_mesh
from skinviz.scene.camera import Camera
from skinviz.scene.hand import hand_frame
from skinviz.scene.lights import DirectionalLight
from skinviz.scene.scene import Scene, Skin
from skinviz.skin.fit import fit_skin
from skinviz.skin.models import skin_model
from skinviz.spectra.archives import load_archive
from skinviz.spectra.illuminants import illuminant_spd
from skinviz.surface.cook_torrance import CookTorrance
from skinviz.surface.lambert import Lambert

WHOSE = {"origin": "China", "subject": "186", "site": "back of hand"}
ROUGHNESS, INDEX = 0.3, 1.4


def scenes(angles: str, size: int) -> dict[str, Scene]:
    """Return our scenes: ``angles`` are the light's and the view's, as "30/0". [deg]"""
    light, view = (np.deg2rad(float(angle)) for angle in angles.split("/"))
    mesh = read_mesh(shipped_mesh(TRUE_SHAPE), "m")
    frame = hand_frame(mesh)
    lambertian = Scene(
        mesh=mesh,
        skin=_skin(),
        surface=Lambert(),
        lights=(DirectionalLight(frame.direction(light)),),
        camera=Camera(frame.direction(-view), frame.fingers, (size, size)),
    )
    rough = CookTorrance(ROUGHNESS, INDEX, specular_scale=0.5, masking="smith")
    return {
        "Lambertian": lambertian,
        "half rough": lambertian.replace(surface=rough, diffuse_scale=0.5),
    }


def as_material(scene: Scene) -> Material:
    """Return a scene's material by numbers alone."""
    reflectance = scene.skin.model.diffuse(scene.skin.values, scene.wavelengths)
    if isinstance(scene.surface, Lambert):
        return Material(reflectance)
    return Material(reflectance, ROUGHNESS, INDEX)


def as_setting(scene: Scene, geometry: Geometry) -> Setting:
    """Return the rest of a scene by numbers alone, our vertex normals among them."""
    points = geometry.centre + geometry.scale * geometry.points
    return Setting(
        points,
        geometry.faces,
        geometry.normals,
        scene.lights[0].direction,
        scene.camera.view(points),
        scene.wavelengths,
        illuminant_spd("D65", scene.wavelengths),
    )


def _skin() -> Skin:
    """Return the two-layer skin fitted to one person's measured spectrum."""
    archive = load_archive("issa")
    chosen = np.all([archive[key].values == WHOSE[key] for key in WHOSE], axis=0)
    model = skin_model(site=WHOSE["site"], specular=archive.attrs["specular"])
    measured = archive.reflectance.values[chosen].mean(axis=0)
    return Skin.from_fit(fit_skin(measured, archive.wavelength.values, model))
