"""Table II: pigment weights by body site."""

from skinviz import figure

print(*figure("table-2").save("figures"), sep="\n")
