"""MVNX: the motion of Xsens suits."""
