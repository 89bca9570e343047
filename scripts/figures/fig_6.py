"""Fig. 6: scattering of epidermis and dermis."""

from skinviz import figure

print(*figure("6").save("figures"), sep="\n")
