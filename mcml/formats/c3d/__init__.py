"""C3D: labelled points of optical systems, binary. Facts and sources: formats.md 5."""
