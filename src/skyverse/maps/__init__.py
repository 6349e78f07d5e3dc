"""Scenarios from other people's maps: terrain, buildings, zones and voxels.

`readers` hold one format each, `georeference` what files say about places on Earth, and `assembly` builds a scenario.
"""
