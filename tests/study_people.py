"""Some of an archive's people."""

import dataclasses


def part(people, which):
    """Return some of the people."""
    return dataclasses.replace(
        people,
        names=tuple(people.names[i] for i in which),
        descriptions=tuple(people.descriptions[i] for i in which),
        reflectance=people.reflectance[which],
    )
