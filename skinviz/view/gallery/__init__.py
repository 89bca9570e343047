"""The figures and tables that skinviz makes by name: one small file each."""
