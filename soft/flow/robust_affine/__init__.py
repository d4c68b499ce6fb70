"""Robust affine flow: the paper's Eq. 3 to 5 taken at their word, in windows that adapt to the motion."""
