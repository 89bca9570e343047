"""How sure the weights are, and what that does to colours."""

from skinviz import figure

print(*figure("uncertainty").save("figures"), sep="\n")
