"""The MCML repository: motion capture in one open XML language."""
