"""BVH: Biovision's hierarchy and motion in one file. See docs/formats/bvh.md."""
