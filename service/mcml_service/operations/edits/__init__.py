"""Operations that change documents or make new ones."""
