"""Other people's maps: terrain, buildings, zones, voxels; each reader a file, and how a scenario is built of them."""
