"""Fig. 5: absorption of the pigments."""

from skinviz import figure

print(*figure("5").save("figures"), sep="\n")
