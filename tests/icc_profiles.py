"""ICC profiles made byte by byte from the standard, to be read back."""

import struct

import numpy as np

D50 = np.array([0.9642, 1.0, 0.8249])
BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
ADOBE_XY = [(0.64, 0.33), (0.21, 0.71), (0.15, 0.06)]
WIDE_XY = [(0.68, 0.32), (0.265, 0.69), (0.15, 0.06)]
D65_XY, D93_XY = (0.3127, 0.3290), (0.2831, 0.2970)


def xyz_of(xy):
    """Return XYZ with Y = 1 of a chromaticity."""
    x, y = xy
    return np.array([x / y, 1.0, (1 - x - y) / y])


def primaries(corners, white):
    """Return XYZ of red, green, blue (columns) that together are the white, Y = 1."""
    own = np.stack([xyz_of(xy) for xy in corners], axis=1)
    return own * np.linalg.solve(own, xyz_of(white))


def to_d50(white):
    """Return the Bradford adaptation (3, 3) from a white to D50."""
    gains = (BRADFORD @ D50) / (BRADFORD @ xyz_of(white))
    return np.linalg.inv(BRADFORD) @ np.diag(gains) @ BRADFORD


def fixed(values):
    """Return numbers as s15Fixed16."""
    whole = [int(v) for v in np.round(np.ravel(values) * 65536)]
    return struct.pack(f">{len(whole)}i", *whole)


def xyz_tag(xyz):
    return b"XYZ \0\0\0\0" + fixed(xyz)


def chad_tag(matrix):
    return b"sf32\0\0\0\0" + fixed(matrix)


def table_tag(points):
    """Return a curve of points in 0–65535, or of one gamma in 1/256, or of none."""
    whole = [int(p) for p in points]
    return b"curv\0\0\0\0" + struct.pack(f">I{len(whole)}H", len(whole), *whole)


def gamma_tag(gamma):
    return table_tag([round(gamma * 256)])


def parametric_tag(kind, *numbers):
    return b"para\0\0\0\0" + struct.pack(">HH", kind, 0) + fixed(numbers)


def text_tag(text):
    """Return a description of version 4."""
    body = text.encode("utf-16-be")
    return (
        b"mluc\0\0\0\0" + struct.pack(">II4sII", 1, 12, b"enUS", len(body), 28) + body
    )


def old_text_tag(text):
    """Return a description of version 2."""
    body = text.encode("latin-1") + b"\0"
    return (
        b"desc\0\0\0\0"
        + struct.pack(">I", len(body))
        + body
        + bytes(4 + 4 + 2 + 1 + 67)
    )


def profile(
    tags, *, version=4, kind=b"mntr", space=b"RGB ", connection=b"XYZ ", mark=b"acsp"
):
    """Return the bytes of a profile with tags by their names."""
    header = bytearray(128)
    header[8:12] = bytes([version, 0x20, 0, 0])
    header[12:24] = kind + space + connection
    header[24:36] = struct.pack(">6H", 2020, 1, 1, 0, 0, 0)
    header[36:40] = mark
    header[68:80] = fixed(D50)
    table, body = struct.pack(">I", len(tags)), b""
    start = 132 + 12 * len(tags)
    for name, data in tags.items():
        table += struct.pack(">4sII", name.encode(), start + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    whole = bytes(header) + table + body
    return struct.pack(">I", len(whole)) + whole[4:]


def display_tags(corners=ADOBE_XY, white=D65_XY, curves=None, *, version=4):
    """Return the tags of a display, its white adapted to D50."""
    own = to_d50(white) @ primaries(corners, white)
    red, green, blue = [gamma_tag(2.2)] * 3 if curves is None else curves
    tags = {
        "desc": text_tag("made") if version == 4 else old_text_tag("made"),
        "wtpt": xyz_tag(D50 if version == 4 else xyz_of(white)),
        "cprt": text_tag("none") if version == 4 else b"text\0\0\0\0none\0",
        "rXYZ": xyz_tag(own[:, 0]),
        "gXYZ": xyz_tag(own[:, 1]),
        "bXYZ": xyz_tag(own[:, 2]),
        "rTRC": red,
        "gTRC": green,
        "bTRC": blue,
    }
    if version == 4:
        tags["chad"] = chad_tag(to_d50(white))
    return tags
