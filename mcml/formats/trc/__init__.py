"""TRC: Motion Analysis' labelled points over time, as text. See docs/formats/trc.md."""
