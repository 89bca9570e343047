"""The worker process: the only place that imports pymeshlab.

Run as a file; the job comes on standard input and the result leaves on standard
output, so that nothing is left on disk however it ends. Imports nothing of
skinviz, so that it starts fast and can be killed at any moment.
"""

import ctypes
import io
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
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as data:
        arrays = {name: data[name] for name in data.files}
    options = {}
    if "normals" in arrays:
        options["v_normals_matrix"] = arrays["normals"]
    if "face_scalars" in arrays:
        options["f_scalar_array"] = arrays["face_scalars"]
    mesh = pymeshlab.Mesh(arrays["points"], arrays["faces"].astype(np.int32), **options)
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
    whole = io.BytesIO()
    np.savez(
        whole,
        points=current.vertex_matrix(),
        faces=current.face_matrix(),
        selected=current.face_selection_array(),
    )
    result.write(whole.getvalue())
    result.close()


if __name__ == "__main__":
    bound(int(sys.argv[1]))
    main()
