"""glTF 2.0: GLB, glTF, VRM and VRMA."""
