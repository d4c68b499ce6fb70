"""Contact values of model grains from what is published of a soil, with the evidence."""
