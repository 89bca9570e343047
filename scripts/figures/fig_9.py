"""Fig. 9: a hand at several angles of illumination and viewing."""

from skinviz import figure

print(*figure("9").save("figures"), sep="\n")
