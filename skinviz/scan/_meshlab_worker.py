"""The worker process: the only place that imports pymeshlab.

Run as a file, with the job's folder as its argument; imports nothing of skinviz
so that it starts fast and can be killed at any moment.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pymeshlab


def main(job: Path) -> None:
    """Read the job's mesh, apply its filters, write the result."""
    with np.load(job / "input.npz") as data:
        arrays = {name: data[name] for name in data.files}
    options = {}
    if "normals" in arrays:
        options["v_normals_matrix"] = arrays["normals"]
    if "face_scalars" in arrays:
        options["f_scalar_array"] = arrays["face_scalars"]
    mesh = pymeshlab.Mesh(arrays["points"], arrays["faces"].astype(np.int32), **options)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(mesh)
    for step in json.loads((job / "filters.json").read_text(encoding="utf-8")):
        parameters = {
            name: pymeshlab.PureValue(value["length"])
            if isinstance(value, dict)
            else value
            for name, value in step["parameters"].items()
        }
        meshes.apply_filter(step["name"], **parameters)
    current = meshes.current_mesh()
    np.savez(
        job / "output.npz",
        points=current.vertex_matrix(),
        faces=current.face_matrix(),
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
