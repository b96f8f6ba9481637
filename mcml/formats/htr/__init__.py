"""HTR and HTR2: Motion Analysis' hierarchical translation and rotation. See docs/formats/htr.md."""
