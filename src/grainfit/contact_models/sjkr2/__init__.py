"""SJKR2: SJKR with an approximate area, which is twice as large between particles."""
