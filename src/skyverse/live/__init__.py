"""Missions in flight: what is seen comes in, and a motion that is proven to have a way out goes out."""
