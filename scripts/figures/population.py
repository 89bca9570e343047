"""The people of the archive, by group and body site."""

from skinviz import figure

print(*figure("population").save("figures"), sep="\n")
