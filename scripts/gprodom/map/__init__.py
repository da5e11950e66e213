"""Map files: what is in them, pictures, parts, exports, and those of the service."""
