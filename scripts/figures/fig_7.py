"""Fig. 7: measured and fitted reflectance of four body sites."""

from skinviz import figure

print(*figure("7").save("figures"), sep="\n")
