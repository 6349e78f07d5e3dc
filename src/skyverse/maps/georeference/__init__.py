"""What files say about places on Earth: datums, longitudes, altitude limits, and the choices that files leave open."""
