"""Table III: errors of fitted spectra."""

from skinviz import figure

print(*figure("table-3").save("figures"), sep="\n")
