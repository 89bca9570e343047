"""Fig. 8: a hand under two illuminants."""

from skinviz import figure

print(*figure("8").save("figures"), sep="\n")
