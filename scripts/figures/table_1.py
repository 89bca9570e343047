"""Table I: thickness of the layers of skin."""

from skinviz import figure

print(*figure("table-1").save("figures"), sep="\n")
