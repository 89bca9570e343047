"""Small shapes whose geometry is known in closed form, in millimetres."""

import numpy as np
import pyvista as pv

from skinviz.scan.topology import polydata


def sphere(radius=40.0, subdivisions=4, centre=(0.0, 0.0, 0.0)):
    """A closed sphere, its points on it to rounding; faces face outwards."""
    import trimesh

    shape = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    unit = shape.vertices / np.linalg.norm(shape.vertices, axis=1, keepdims=True)
    return polydata(radius * unit + np.asarray(centre), np.asarray(shape.faces))


def tube(radius=20.0, length=100.0, n_around=48, n_along=30):
    """A cylinder along z without ends; faces face outwards."""

    def section(z, turn):
        return np.full_like(z, radius), np.full_like(turn, radius)

    return polydata(*_sleeve(section, length, n_around, n_along))


def plane(n=9, size=40.0):
    """A square in the plane z = 0, facing +z, of 2 (n - 1)² equal triangles."""
    x = np.linspace(-size / 2, size / 2, n)
    points = np.stack([*np.meshgrid(x, x), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + n + 1], axis=1)
    upper = np.stack([corner, corner + n + 1, corner + n], axis=1)
    return polydata(points, np.concatenate([lower, upper]))


def wave(n=33, size=40.0, height=2.0):
    """A curved sheet over a square of n × n points, seen from +z without folds."""
    flat = plane(n, size)
    points = np.array(flat.points)
    points[:, 2] = height * np.sin(points[:, 0] / 7) * np.cos(points[:, 1] / 5)
    return polydata(points, faces_of(flat))


def tetrahedron():
    """Four points, four faces that face outwards, volume 1/6."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    return polydata(points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))


def cube(size=2.0):
    """A closed cube about the origin, made of quadrilaterals."""
    return pv.Cube(x_length=size, y_length=size, z_length=size).clean()


def toy_hand(length=180.0, n_around=72, n_along=90):
    """A mitten: open at z = 0, tip at z = length, back +y, thumb at +x and palmar.

    So its fingers are +z, its back +y, and its side z × y = -x.
    """

    def section(z, turn):
        taper = np.sqrt(np.maximum(1 - (z / length) ** 4, 0.0))
        towards_thumb = np.angle(np.exp(1j * (turn + np.deg2rad(30))))
        at = np.exp(-(((z - 0.45 * length) / 18) ** 2) - (towards_thumb / 0.35) ** 2)
        return taper * (42 + 45 * at), taper * (16 + 10 * at)

    points, faces = _sleeve(section, length, n_around, n_along)
    # The last ring has shrunk to the tip: one point closes it.
    ring = n_around * n_along
    points = np.concatenate([points[:ring], [[0.0, 0.0, length]]])
    return polydata(*_drop_empty(points, np.minimum(faces, ring)))


def grid(height, pitch=1.0):
    """A range view of heights (rows, columns) above evenly spaced cells."""
    rows, columns = height.shape
    x, y = np.meshgrid(pitch * np.arange(columns), pitch * np.arange(rows))
    points = np.stack([x, y, height], axis=-1)
    return np.where(np.isfinite(height)[..., None], points, np.nan)


def with_forearm(mesh, length, step=5.0, bend=0.0):
    """A hand whose opening is drawn out along a forearm that widens like a cone.

    Its sections grow by 60 % in 150 mm; ``bend`` [rad] turns its axis from the
    hand's, which is taken to be from the opening to the mesh's middle.
    """
    from skinviz.scan.wrist import wrist_loop

    points, faces = np.asarray(mesh.points, dtype=float), faces_of(mesh)
    loop = wrist_loop(points, faces)
    rim = points[loop]
    centre = rim.mean(axis=0)
    _, axes = np.linalg.eigh((rim - centre).T @ (rim - centre))
    away = axes[:, 0] * -np.sign((points.mean(axis=0) - centre) @ axes[:, 0])
    u, v = axes[:, 2], np.cross(away, axes[:, 2])
    turn = np.argsort(np.arctan2((rim - centre) @ v, (rim - centre) @ u))
    loop, rim = loop[turn], rim[turn]
    axis = np.cos(bend) * away + np.sin(bend) * u
    n_rings = max(int(np.ceil(length / step)), 1)
    along = length * np.arange(1, n_rings + 1) / n_rings
    rings = [rim + 0.004 * d * (rim - centre) + d * axis for d in along]
    k = len(rim)
    index = np.concatenate([loop, len(points) + np.arange(k * n_rings)])
    here = (k * np.arange(n_rings)[:, None] + np.arange(k)).ravel()
    beside = (k * np.arange(n_rings)[:, None] + (np.arange(k) + 1) % k).ravel()
    sleeve = np.concatenate(
        [
            np.stack([here, beside, here + k], axis=1),
            np.stack([beside, beside + k, here + k], axis=1),
        ]
    )
    sleeve = index[sleeve]
    # The first edge runs against that of the face which it joins.
    ends = {tuple(e) for e in faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    if tuple(sleeve[0, :2].tolist()) in ends:
        sleeve = sleeve[:, ::-1]
    return polydata(np.concatenate([points, *rings]), np.concatenate([faces, sleeve]))


def moved(mesh, pose):
    """A copy of a mesh after a rigid motion (4, 4)."""
    points = np.asarray(mesh.points) @ pose[:3, :3].T + pose[:3, 3]
    return polydata(points, faces_of(mesh))


def joined(*meshes):
    """Several meshes as one, not connected with each other."""
    points, faces, count = [], [], 0
    for mesh in meshes:
        points.append(np.asarray(mesh.points))
        faces.append(faces_of(mesh) + count)
        count += mesh.n_points
    return polydata(np.concatenate(points), np.concatenate(faces))


def without_faces(mesh, drop):
    """A copy of a mesh without the faces for which ``drop`` is true."""
    faces = faces_of(mesh)
    return polydata(np.asarray(mesh.points), faces[~np.asarray(drop)])


def faces_of(mesh):
    """The corners (m, 3) of a mesh's triangles."""
    return np.asarray(mesh.regular_faces, dtype=np.int64)


def face_centres(mesh):
    """Centres of the faces (m, 3)."""
    return np.asarray(mesh.points)[mesh.regular_faces].mean(axis=1)


def pose(rotation_vector=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    """A rigid motion (4, 4) from a rotation vector [rad] and a shift [mm]."""
    from scipy.spatial.transform import Rotation

    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(rotation_vector).as_matrix()
    motion[:3, 3] = shift
    return motion


def distance_to(mesh, points):
    """Unsigned distances (n,) from points to a mesh's surface, by VTK. [mm]"""
    found = pv.PolyData(np.asarray(points, dtype=np.float64))
    found = found.compute_implicit_distance(mesh)
    return np.abs(np.asarray(found["implicit_distance"]))


def _sleeve(section, length, n_around, n_along):
    """Points and outward faces of rings stacked along z, both ends open."""
    z = np.repeat(np.linspace(0.0, length, n_along + 1), n_around)
    turn = np.tile(2 * np.pi * np.arange(n_around) / n_around, n_along + 1)
    wide, thick = section(z, turn)
    points = np.stack([wide * np.cos(turn), thick * np.sin(turn), z], axis=1)
    first = np.arange(n_along)[:, None] * n_around
    here = (first + np.arange(n_around)).ravel()
    beside = (first + (np.arange(n_around) + 1) % n_around).ravel()
    faces = np.concatenate(
        [
            np.stack([here, beside, beside + n_around], axis=1),
            np.stack([here, beside + n_around, here + n_around], axis=1),
        ]
    )
    return points, faces


def _drop_empty(points, faces):
    """Drop faces that name a point twice."""
    a, b, c = faces.T
    return points, faces[(a != b) & (b != c) & (c != a)]
