"""C3D: labelled points of optical systems, binary. See docs/formats/c3d.md."""
