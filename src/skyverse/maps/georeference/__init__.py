"""What files say about places on Earth: datums, longitudes, altitude limits, and what they leave to the user."""
