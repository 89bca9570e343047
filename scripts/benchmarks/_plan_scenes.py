"""Random scenes that plans are tried on: each is made of its seed alone."""

from functools import cache

import numpy as np

from skinviz import (
    Camera,
    CookTorrance,
    DirectionalLight,
    Illuminant,
    PointLight,
    Scene,
    Skin,
    SkinTexture,
    TorranceSparrow,
    fit_skin,
    hand_frame,
    illuminants,
    line_lamp,
    load_archive,
    skin_model,
    textured,
)
from skinviz.scan.formats import read_mesh
from skinviz.scan.shipped import shipped_mesh
from skinviz.scan.topology import arrays, polydata
from skinviz.surface.dispersion import dispersion

HAND = "makehuman_male_right.ply"
SITES = ("cheek", "back of hand", "outer arm", "inner arm")
SMALLEST, LARGEST = 64, 1024  # pixels a side


def scene_of(seed: int) -> Scene:
    """Return one scene."""
    rng = np.random.default_rng([2005, seed])
    mesh = hand(int(rng.integers(4)))
    frame = hand_frame(mesh)
    side = int(np.exp(rng.uniform(np.log(SMALLEST), np.log(LARGEST))))
    view = turned(frame, rng, np.deg2rad(80))
    extent = np.ptp(np.asarray(mesh.points), axis=0).max()
    close = rng.random() < 0.3
    points = np.asarray(mesh.points)
    facing = points[np.argsort(points @ view)[-len(points) // 4 :]]
    camera = Camera(
        view,
        frame.fingers + 0.01 * frame.side,
        (side, max(SMALLEST // 2, int(side * rng.uniform(0.6, 1.0)))),
        distance=np.inf if rng.random() < 0.6 else extent * rng.uniform(1.5, 5),
        target=facing[rng.integers(len(facing))] if close else None,
        height=extent * rng.uniform(0.05, 0.4) if close else None,
    )
    surface = (TorranceSparrow, CookTorrance)[int(rng.random() < 0.2)]
    width = {"gamma": np.exp(rng.uniform(np.log(0.02), np.log(1.0)))}
    if surface is CookTorrance:
        width = {"roughness": float(rng.uniform(0.05, 0.6))}
    return Scene(
        mesh=mesh,
        skin=skin(mesh, rng),
        surface=surface(
            **width,
            n=1.4 if rng.random() < 0.7 else dispersion("epidermis"),
            specular_scale=float(rng.uniform(0, 1.2)),
        ),
        lights=tuple(
            light(frame, mesh, rng) for _ in range(1 + int(rng.random() < 0.25))
        ),
        camera=camera,
        exposure=1.0 if rng.random() < 0.7 else float(np.exp(rng.uniform(-1, 1))),
        observer="cie1931" if rng.random() < 0.8 else "cie1964",
        interreflection="diffuse" if rng.random() < 0.4 else "none",
    )


def textured_scene_of(seed: int) -> Scene:
    """Return the same scene with uneven skin."""
    rng = np.random.default_rng([2006, seed])
    texture = SkinTexture(
        melanin_mottling=float(rng.uniform(0, 0.3)),
        blood_mottling=float(rng.uniform(0, 0.3)),
        mottling_mm=float(rng.uniform(6, 12)),
        veins=float(rng.uniform(0, 0.05)),
        vein_width_mm=6.0,
        knuckle_redness=float(rng.uniform(0, 1)),
        crease_redness=float(rng.uniform(0, 1)),
        relief_um=float(rng.uniform(0, 80)),
        relief_mm=float(np.exp(rng.uniform(np.log(0.3), np.log(4)))),
        seed=seed,
    )
    return textured(scene_of(seed), texture)


@cache
def hand(kind: int):
    """Return a right or a left hand, fine or coarse."""
    right = read_mesh(shipped_mesh(HAND), "m")
    if kind >= 2:
        right = right.decimate(0.8)
    points, faces = arrays(right)
    if kind % 2:
        points, faces = points * np.array([-1.0, 1, 1]), faces[:, ::-1].copy()
    return polydata(points, faces)


def turned(frame, rng, most):
    """Return a direction up to ``most`` from the hand's back [rad]."""
    away, round_it = most * np.sqrt(rng.random()), rng.uniform(0, 2 * np.pi)
    across = np.cos(round_it) * frame.fingers + np.sin(round_it) * frame.side
    return np.cos(away) * frame.back + np.sin(away) * across


def light(frame, mesh, rng):
    """Return a light, near or far, from the back's side, to grazing."""
    lamp, strength = lamp_of(rng), float(np.exp(rng.uniform(-1.5, 1)))
    direction = turned(frame, rng, np.deg2rad(88))
    if rng.random() < 0.7:
        return DirectionalLight(direction, lamp, strength)
    points = np.asarray(mesh.points)
    away = np.ptp(points, axis=0).max() * rng.uniform(0.8, 3)
    return PointLight(points.mean(axis=0) + away * direction, lamp, strength)


def lamp_of(rng):
    """Return a CIE illuminant, a black body, an LED of some peaks, or lines."""
    kind = rng.random()
    if kind < 0.5:
        return str(rng.choice(illuminants()))
    if kind < 0.65:
        return f"{rng.uniform(2000, 9000):.0f} K"
    if kind < 0.8:
        nm = np.arange(380.0, 781.0)
        peaks = np.array([rng.uniform(440, 480), rng.uniform(510, 560), 620.0])
        widths = rng.uniform(8, 25, 3)
        bands = np.exp(-(((nm[:, None] - peaks) / widths) ** 2) / 2)
        return Illuminant("an LED", nm, bands @ rng.uniform(0.3, 1, 3))
    if kind < 0.9:
        return line_lamp([[float(rng.uniform(440, 660)), 1.0]])
    nm = np.sort(rng.uniform(430, 670, int(rng.integers(2, 6))))
    return line_lamp(np.stack([nm, rng.uniform(0.2, 1, nm.size)], axis=1))


@cache
def spectra():
    """Return the archive's spectra and their wavelengths."""
    archive = load_archive("nist")
    return archive.reflectance.values, archive.wavelength.values


def skin(mesh, rng):
    """Return somebody's skin: one on all of the hand, or a map of it."""
    reflectance, nm = spectra()
    model = skin_model(site=str(rng.choice(SITES)), specular="included")
    fit = fit_skin(reflectance[rng.integers(len(reflectance))], nm, model)
    values = np.maximum(fit.values, 1e-6)
    kind = rng.random()
    if kind < 0.5:
        return Skin(model, values)
    points = np.asarray(mesh.points)
    unit = (points - points.mean(axis=0)) / np.ptp(points, axis=0).max()
    if kind < 0.75:  # waves
        phases = unit @ rng.normal(0, 12, (3, 3)) + rng.uniform(0, 6, 3)
        factors = np.exp(rng.uniform(0.1, 1.0, 3) * np.sin(phases))
    elif kind < 0.9:  # spots with sharp edges
        centres = unit[rng.integers(len(unit), size=30)]
        near = np.linalg.norm(unit[:, None] - centres, axis=2).min(axis=1) < 0.03
        factors = 1 + near[:, None] * rng.uniform(0.5, 4, 3)
    else:  # noise
        factors = np.exp(rng.normal(0, 0.2, (len(unit), 3)))
    return Skin(model, values * factors)
