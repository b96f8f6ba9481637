"""SMPL, SMPL-H and SMPL-X: pose parameters of body models as AMASS writes them."""
