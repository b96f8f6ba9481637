"""Motion files to clips and back."""
