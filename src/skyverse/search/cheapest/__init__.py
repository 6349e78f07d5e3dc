"""Cheap paths of straight legs under a whole objective: a roadmap proposes ways, and descent makes each cheaper."""
