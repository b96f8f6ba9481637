"""Mathematics of the gait laboratory on arrays; it knows no file formats."""
