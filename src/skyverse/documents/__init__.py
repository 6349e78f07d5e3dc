"""Nested documents, JSON, YAML and XML: read within limits on their size, so that no file can exhaust the machine."""
