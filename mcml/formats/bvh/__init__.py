"""BVH: Biovision's hierarchy and motion in one file. Facts and sources: formats.md 1."""
