"""HTR and HTR2: Motion Analysis' hierarchical translation and rotation. Facts and sources: formats.md 4."""
