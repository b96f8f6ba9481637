"""FBX, read by ufbx."""
