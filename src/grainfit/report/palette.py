"""Colours of data (Okabe and Ito 2008), told apart by the colour-blind and on light and dark."""

BLUE = "#0072B2"
ORANGE = "#E69F00"
GREEN = "#009E73"
VERMILLION = "#D55E00"
GREY = "#888888"
