"""The MCML repository: motion capture in one open XML language."""

import warnings

# Sums and products of numbers near 1e308: the results are looked at where they are kept, and nobody who sends such a
# file can read what NumPy prints.
warnings.filterwarnings("ignore", r"(overflow|invalid value) encountered", RuntimeWarning)
