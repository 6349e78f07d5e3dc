"""Surveys: from what is to be seen to the lines along which photos are taken."""
