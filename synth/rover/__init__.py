"""A rover on soft soil: its vehicle and gaits in MuJoCo, the force of the soil on its wheels, the drawbar test."""
