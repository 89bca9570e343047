"""Skins that match under daylight and not under other lights."""

from skinviz import figure

print(*figure("metamerism").save("figures"), sep="\n")
