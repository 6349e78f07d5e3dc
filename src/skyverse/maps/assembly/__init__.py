"""How terrain, buildings, zones and places become one scenario in local metres."""
