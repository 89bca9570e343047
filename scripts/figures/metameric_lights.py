"""A hand under lights of one white."""

from skinviz import figure

print(*figure("metameric-lights").save("figures"), sep="\n")
