"""Fig. 10: hands with several amounts of melanin and oxyhaemoglobin."""

from skinviz import figure

print(*figure("10").save("figures"), sep="\n")
