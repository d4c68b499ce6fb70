"""A rover on soft soil: its vehicle and gaits in MuJoCo, the soil's force on its wheels, the drawbar test."""
