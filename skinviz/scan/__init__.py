"""Range scans: formats, alignment, cleaning to hand meshes, a scanner simulator."""
