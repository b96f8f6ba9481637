"""TRC: Motion Analysis' labelled points over time, as text. Facts and sources: formats.md 6."""
