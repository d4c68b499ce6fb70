"""Dense flow by a robust energy: Black and Anandan (Computer Vision and Image Understanding 63, 1996)."""
