"""The worker process: the only place that imports pymeshlab.

Run as a file; standard input is a file with the job and standard output one for the
result, so that this process leaves nothing on disk however it ends. Imports nothing of
skinviz, so that it starts fast and can be killed at any moment.
"""

import ctypes
import json
import os
import resource
import signal
import sys

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG


def bound(memory: int) -> None:
    """End with the process that started this one; take no more memory than told."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if memory:
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def main() -> None:
    """Read the job's mesh, apply its filters, write the result."""
    import numpy as np
    import pymeshlab

    result = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what filters print must not get into the result
    with np.load(sys.stdin.buffer) as data:
        arrays = {name: data[name] for name in data.files}
    options = {}
    if "normals" in arrays:
        options["v_normals_matrix"] = arrays["normals"]
    if "face_scalars" in arrays:
        options["f_scalar_array"] = arrays["face_scalars"]
    mesh = pymeshlab.Mesh(arrays["points"], arrays["faces"], **options)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(mesh)
    for step in json.loads(arrays["filters"].tobytes()):
        parameters = {
            name: pymeshlab.PureValue(value["length"])
            if isinstance(value, dict)
            else value
            for name, value in step["parameters"].items()
        }
        meshes.apply_filter(step["name"], **parameters)
    current = meshes.current_mesh()
    np.savez(
        result,
        points=current.vertex_matrix(),
        faces=current.face_matrix(),
        selected=current.face_selection_array(),
    )
    result.close()


if __name__ == "__main__":
    bound(int(sys.argv[1]))
    main()
