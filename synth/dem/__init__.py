"""The grains: contact law, neighbours, integration, bed, the run."""
