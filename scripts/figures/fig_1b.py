"""Fig. 1b: the back of a hand under light from several angles."""

from skinviz import figure

print(*figure("1b").save("figures"), sep="\n")
