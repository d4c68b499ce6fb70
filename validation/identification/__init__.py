"""The wheel-soil law, fitted to single wheels in the granular bin, held against what it was not fitted to."""
