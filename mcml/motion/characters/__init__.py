"""Bodies with a skin: a low-polygon figure of this project's own, made to the measure of any person's rig."""
