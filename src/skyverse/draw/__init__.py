"""Pictures of a mission: first as data (`scene`), then as a page (`html`) and as figures (`figures`)."""
