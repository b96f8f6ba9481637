"""Commands that change documents or make new ones."""
