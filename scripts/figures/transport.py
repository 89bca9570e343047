"""The model's error against radiative transport."""

from skinviz import figure

print(*figure("transport").save("figures"), sep="\n")
