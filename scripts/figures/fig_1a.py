"""Fig. 1a: reflectance of skin at several sites of the body."""

from skinviz import figure

print(*figure("1a").save("figures"), sep="\n")
